// SPDX-License-Identifier: BSD-3-Clause
// The latest value for many readers: its contract on one thread, and under load with several readers.
// ThreadSanitizer builds run the same.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "rt/latest_value.hpp"
#include "tests/rt/queue_message.hpp"

namespace sortie::rt {
namespace {

using test::intact;
using test::make_message;
using test::Message;

}  // namespace

TEST_CASE("every reader of a latest value gets the newest once as fresh, and keeps it") {
  LatestValue<int, 2> box;
  auto* const one = box.reader(0);
  auto* const two = box.reader(1);
  REQUIRE(one != nullptr);
  REQUIRE(two != nullptr);
  CHECK(box.reader(2) == nullptr);
  int value = -1;
  CHECK_FALSE(one->read(value));
  CHECK(value == 0);
  CHECK(one->generation() == 0);
  box.write(5);
  CHECK(one->read(value));
  CHECK(value == 5);
  CHECK(one->generation() == 1);
  CHECK_FALSE(one->read(value));
  CHECK(value == 5);
  box.write(6);
  box.write(7);
  CHECK(one->value() == 5);  // held, whatever the writer does
  CHECK(two->read(value));
  CHECK(value == 7);
  CHECK(two->generation() == 3);
  CHECK(one->refresh());
  CHECK(one->value() == 7);
  CHECK(one->generation() == 3);
  box.draft() = 8;
  box.draft() += 1;
  CHECK_FALSE(one->refresh());
  box.publish();
  CHECK(one->refresh());
  CHECK(one->value() == 9);
  CHECK(box.generation() == 4);
  box.publish();  // an older value again, but news
  CHECK(one->refresh());
  CHECK(one->generation() == 5);
}

TEST_CASE("readers of a latest value that stay where they are never see it change") {
  constexpr std::uint32_t kReaders = 5;
  LatestValue<std::uint64_t, kReaders> box;
  std::array<std::uint64_t, kReaders> held{};
  std::mt19937_64 engine(41);
  INFO("seed 41");
  std::uint64_t written = 0;
  for (int step = 0; step < 20000; ++step) {
    const auto who = static_cast<std::uint32_t>(engine() % 8);
    if (who < kReaders) {
      REQUIRE(box.reader(who)->refresh() == (held[who] != written));
      held[who] = written;
    } else {
      box.write(++written);
    }
    for (std::uint32_t i = 0; i < kReaders; ++i) {
      REQUIRE(box.reader(i)->value() == held[i]);
      REQUIRE(box.reader(i)->generation() == held[i]);
    }
  }
}

TEST_CASE("a latest value carries what cannot be copied byte by byte") {
  struct Shared {
    Shared() = default;
    Shared(const Shared&) = default;
    Shared& operator=(const Shared& other) noexcept {
      text = other.text;
      return *this;
    }
    std::string text;
  };
  LatestValue<Shared, 1> box;
  Shared value;
  value.text = std::string(100, 'x');
  box.write(value);
  CHECK(box.reader(0)->refresh());
  CHECK(box.reader(0)->value().text == value.text);
}

TEST_CASE("a latest value between threads is never torn and never runs backwards for any reader") {
  constexpr std::uint64_t kMessages = 100000;
  static LatestValue<Message, 4> box;
  box.write(make_message(0));
  std::array<std::uint64_t, 3> faults{};
  std::vector<std::thread> threads;
  for (std::uint32_t index = 0; index < 3; ++index) {
    threads.emplace_back([index, &faults] {
      auto& reader = *box.reader(index);
      std::uint64_t last = 0;
      while (last < kMessages) {
        const bool fresh = reader.refresh();
        const std::uint64_t number = reader.value().words[0];
        if (index == 0) std::this_thread::yield();  // holds its value for long
        if (!intact(reader.value()) || reader.value().words[0] != number) ++faults[index];
        if (reader.generation() != number + 1 && (last != 0 || fresh)) ++faults[index];
        if (fresh && last != 0 ? number <= last : number < last) ++faults[index];
        last = number;
        if (!fresh) std::this_thread::yield();
      }
    });
  }
  for (std::uint64_t i = 1; i <= kMessages; ++i) {
    box.write(make_message(i));
    if (i % 64 == 0) std::this_thread::yield();
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(faults == std::array<std::uint64_t, 3>{});
  CHECK(box.generation() == kMessages + 1);
  CHECK_FALSE(box.reader(0)->refresh());
  CHECK(box.reader(3)->refresh());  // the place that nobody used
  CHECK(box.reader(3)->value().words[0] == kMessages);
}

}  // namespace sortie::rt
