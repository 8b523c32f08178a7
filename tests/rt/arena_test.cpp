// SPDX-License-Identifier: BSD-3-Clause
// Arena and fixed vector: memory is taken once, listed by name, and what does not fit is refused and counted.
#include <array>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "rt/arena.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::rt {
namespace {

struct Element {
  double value{42.0};
  std::int32_t tag{};
};

}  // namespace

TEST_CASE("an arena lists every allocation with its name and its bytes") {
  alignas(64) std::array<std::byte, 4096> memory;
  memory.fill(std::byte{0xaa});
  Arena arena(memory);
  const std::span<char> odd = arena.make_array<char>("odd", 3);
  const std::span<Element> elements = arena.make_array<Element>("elements", 10);
  double* const one = arena.make_array<double>("one", 1).data();
  REQUIRE(odd.size() == 3);
  REQUIRE(elements.size() == 10);
  REQUIRE(one != nullptr);
  CHECK(odd[2] == 0);
  CHECK(elements[9].value == 42.0);
  CHECK(*one == 0.0);
  CHECK(reinterpret_cast<std::uintptr_t>(elements.data()) % alignof(Element) == 0);

  const auto report = arena.report();
  REQUIRE(report.size() == 3);
  CHECK(std::string(report[0].name) == "odd");
  CHECK(report[0].bytes == 3);
  CHECK(std::string(report[1].name) == "elements");
  CHECK(report[1].capacity == 10);
  CHECK(report[1].element_bytes == sizeof(Element));
  CHECK(report[1].bytes == 10 * sizeof(Element) + 5);  // five bytes of gap behind "odd"
  CHECK_FALSE(report[1].refused);
  CHECK(arena.used_bytes() == 8 + 10 * sizeof(Element) + 8);
  CHECK(arena.refused() == 0);
  CHECK(arena.needed_bytes() >= arena.used_bytes());
}

TEST_CASE("an arena that was made to end earlier keeps what was taken, and refuses what lies behind") {
  alignas(8) std::array<std::byte, 256> memory{};
  Arena arena(memory);
  const std::span<double> kept = arena.make_array<double>("kept", 4);
  arena.end_at(8);  // less than was taken
  CHECK(arena.make_array<char>("behind", 1).data() == nullptr);
  CHECK(arena.refused() == 1);
  CHECK(kept.size() == 4);
  Arena other(memory);
  CHECK(other.make_array<double>("first", 1).data() != nullptr);
  other.end_at(16);
  other.end_at(256);  // it does not grow again
  CHECK(other.make_array<double>("second", 1).data() != nullptr);
  CHECK(other.make_array<char>("third", 1).data() == nullptr);
}

TEST_CASE("allocations of an arena never overlap and keep their alignment wherever the block starts") {
  std::mt19937_64 engine(7);
  for (std::size_t start = 0; start < 64; ++start) {
    alignas(64) std::array<std::byte, 5000> memory{};
    Arena arena(std::span<std::byte>(memory).subspan(start));
    const std::byte* end = memory.data() + start;
    for (int i = 0; i < 20; ++i) {
      const std::size_t alignment = std::size_t{1} << (engine() % 7);
      const auto count = static_cast<std::size_t>(engine() % 100);
      const std::span<std::uint8_t> block = arena.make_array<std::uint8_t>("block", count, alignment);
      if (count == 0) {
        CHECK(block.empty());
        continue;
      }
      REQUIRE(block.size() == count);
      const std::byte* const begin = reinterpret_cast<const std::byte*>(block.data());
      REQUIRE(begin >= end);
      REQUIRE(reinterpret_cast<std::uintptr_t>(begin) % alignment == 0);
      end = begin + count;
      REQUIRE(end <= memory.data() + memory.size());
    }
  }
}

TEST_CASE("an arena refuses what does not fit, says how much would, and goes on") {
  std::array<std::byte, 100> memory{};
  Arena arena(memory);
  CHECK(arena.make_array<std::uint8_t>("fits", 60).size() == 60);
  CHECK(arena.make_array<std::uint8_t>("too large", 41).empty());
  const volatile std::size_t absurd =
      SIZE_MAX / 4;  // a compiler that knows it warns of the loop that is never reached
  CHECK(arena.make_array<double>("absurd", absurd).empty());
  CHECK(arena.make_array<std::uint8_t>("fits again", 40).size() == 40);
  CHECK(arena.make_array<char>("full", 1).data() == nullptr);
  CHECK(arena.refused() == 3);
  CHECK(arena.report()[1].refused);
  CHECK(arena.report()[1].bytes == 0);
  CHECK(arena.used_bytes() == 100);

  std::array<std::byte, 100> first{};
  Arena small(first);
  CHECK(small.make_array<double>("a", 11).size() + small.make_array<double>("b", 11).size() < 22);
  std::vector<std::byte> enough(static_cast<std::size_t>(small.needed_bytes()));
  Arena large(enough);
  CHECK(large.make_array<double>("a", 11).size() == 11);
  CHECK(large.make_array<double>("b", 11).size() == 11);
}

TEST_CASE("an arena holds a limited number of names and cuts long ones") {
  std::vector<std::byte> memory(10000);
  Arena arena(memory);
  CHECK_FALSE(arena.make_array<char>(std::string(200, 'n').c_str(), 1).empty());
  CHECK(std::string(arena.report()[0].name) == std::string(47, 'n'));
  for (std::uint32_t i = 1; i < kMaxArenaPools; ++i)
    REQUIRE(arena.make_array<char>("x", 1).data() != nullptr);
  CHECK(arena.make_array<char>("one too many", 1).data() == nullptr);
  CHECK(arena.refused() == 1);
}

TEST_CASE("a fixed vector behaves as std::vector until it is full, then refuses") {
  FixedVector<int, 16> fixed;
  std::vector<int> twin;
  std::mt19937_64 engine(3);
  INFO("seed 3");
  for (int step = 0; step < 5000; ++step) {
    switch (engine() % 5) {
      case 0:
      case 1: {
        const bool pushed = fixed.push_back(step);
        REQUIRE(pushed == (twin.size() < 16));
        if (pushed) twin.push_back(step);
        break;
      }
      case 2:
        fixed.pop_back();
        if (!twin.empty()) twin.pop_back();
        break;
      case 3: {
        const auto i = static_cast<std::uint32_t>(engine() % 18);
        fixed.erase(i);
        if (i < twin.size()) twin.erase(twin.begin() + i);
        break;
      }
      default: {
        const auto size = static_cast<std::uint32_t>(engine() % 18);
        REQUIRE(fixed.resize(size) == (size <= 16));
        if (size <= 16) twin.resize(size);
      }
    }
    REQUIRE(std::vector<int>(fixed.begin(), fixed.end()) == twin);
    REQUIRE(fixed.empty() == twin.empty());
    REQUIRE(fixed.full() == (twin.size() == 16));
    REQUIRE((fixed.at(fixed.size()) == nullptr));
  }
  fixed.clear();
  CHECK(fixed.empty());
}

}  // namespace sortie::rt
