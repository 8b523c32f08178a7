// SPDX-License-Identifier: BSD-3-Clause
// One writer and some readers of a latest value, in every interleaving.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {

/// The writer writes 1, 2, 3, ...; each reader reads its number of times. Values never run backwards, "fresh"
// means newer, the generation is the value's own, and after the end everybody finds the last value.
template <class Box>
Result many_readers(int writes, const std::vector<int>& reads, bool stop_at_failure) {
  std::unique_ptr<Box> box;
  std::vector<int> last(reads.size());
  Explorer& explorer = Explorer::instance();
  const auto look = [&](std::uint32_t index) {
    Tracked value(-1);
    auto* const reader = box->reader(index);
    const bool fresh = reader->read(value);
    const int got = value.read();
    if (fresh ? got <= last[index] : got != last[index]) explorer.fail();
    if (reader->generation() != static_cast<std::uint64_t>(got)) explorer.fail();
    last[index] = got;
  };
  std::vector<std::function<void()>> bodies{[&] {
    for (int i = 1; i <= writes; ++i) box->write(Tracked(i));
  }};
  for (std::uint32_t index = 0; index < reads.size(); ++index) {
    bodies.emplace_back([&, index] {
      for (int i = 0; i < reads[index]; ++i) look(index);
    });
  }
  const std::uint64_t executions = explorer.explore(
      [&] {
        box = std::make_unique<Box>();
        for (int& each : last) each = 0;
      },
      bodies,
      [&] {
        for (std::uint32_t index = 0; index < reads.size(); ++index) {
          look(index);
          if (last[index] != writes) explorer.fail();
        }
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

}  // namespace sortie::rt::test
