// SPDX-License-Identifier: BSD-3-Clause
// Logs for tests: items of random bytes, written to a file that is gone at the end.
#pragma once

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "drivers/lcm_log.hpp"

namespace sortie::test {

using Bytes = std::vector<std::uint8_t>;
using drivers::LcmLogWriter;
using drivers::LogEvent;

// A path of its own per test, gone at the end.
class TempFile {
 public:
  explicit TempFile(const char* name)
      : path_(std::filesystem::temp_directory_path() / ("sortie_" + std::to_string(getpid()) + "_" + name)) {}
  ~TempFile() { std::filesystem::remove(path_); }
  std::string path() const { return path_.string(); }
  Bytes read() const {
    std::ifstream in(path_, std::ios::binary);
    return Bytes(std::istreambuf_iterator<char>(in), {});
  }
  void write(std::span<const std::uint8_t> bytes) const {
    std::ofstream out(path_, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  std::filesystem::path path_;
};

struct Item {
  std::string channel;
  std::int64_t time_us{};
  Bytes data;
};

inline std::vector<Item> some_items(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Item> items;
  for (int i = 0; i < count; ++i) {
    Item item;
    item.channel = "CHANNEL_" + std::to_string(i % 7);
    item.time_us = 1'700'000'000'000'000 + i * 1000;
    item.data.resize(random() % 200);
    for (auto& byte : item.data) byte = static_cast<std::uint8_t>(random());
    items.push_back(item);
  }
  return items;
}

inline void write_log(const std::string& path, const std::vector<Item>& items, std::size_t buffer = 4096) {
  LcmLogWriter writer(path, buffer);
  for (const Item& item : items) REQUIRE(writer.append(item.channel, item.time_us, item.data) == Status::ok);
  REQUIRE(writer.close() == Status::ok);
  REQUIRE(writer.events() == items.size());
}

inline bool same(const LogEvent& event, const Item& item) {
  return event.channel == item.channel && event.timestamp_us == item.time_us &&
         std::equal(event.data.begin(), event.data.end(), item.data.begin(), item.data.end());
}

}  // namespace sortie::test
