// SPDX-License-Identifier: BSD-3-Clause
// The overwriting ring: against a plain list on one thread, and under load with several readers.
// ThreadSanitizer builds run the same.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "rt/overwrite_ring.hpp"
#include "tests/rt/queue_message.hpp"

namespace sortie::rt {
namespace {

using test::intact;
using test::make_message;
using test::Message;

// Pushes and reads of three readers in random order, each reader beside a list of what it may still get.
// Returns what the reader that looks rarely has lost by the end, as its list counts it.
template <std::uint32_t N>
std::uint64_t against_lists(std::uint32_t first_index, std::uint64_t seed) {
  OverwriteRing<std::uint16_t, N> ring(first_index);
  using Reader = typename OverwriteRing<std::uint16_t, N>::Reader;
  std::array<Reader, 3> readers{Reader(ring), Reader(ring), Reader(ring)};
  std::array<std::deque<std::uint16_t>, 3> twins;
  std::array<std::uint32_t, 3> lost{};
  std::array<std::uint64_t, 3> lost_in_all{};
  std::mt19937_64 engine(seed);
  std::uint16_t next = 0;
  INFO("seed " << seed);
  for (int step = 0; step < 20000; ++step) {
    const auto who = static_cast<std::size_t>(engine() % 5);
    if (who >= 3) {
      ring.push(next);
      for (std::size_t i = 0; i < 3; ++i) {
        twins[i].push_back(next);
        if (twins[i].size() < N) continue;
        twins[i].pop_front();
        ++lost[i];
      }
      ++next;
      continue;
    }
    if (who == 2 && engine() % 8 != 0) continue;  // one that looks rarely
    std::uint16_t value = 4711;
    std::uint32_t passed_over = 0;
    const Status status = readers[who].read(value, passed_over);
    REQUIRE(status == (twins[who].empty() ? Status::empty : Status::ok));
    REQUIRE(passed_over == lost[who]);
    REQUIRE(value == (twins[who].empty() ? 4711 : twins[who].front()));
    if (!twins[who].empty()) twins[who].pop_front();
    lost_in_all[who] += lost[who];
    lost[who] = 0;
    REQUIRE(readers[who].lost() == lost_in_all[who]);
  }
  return lost_in_all[2];
}

// Reads until `end` was seen. Returns the number of faults.
template <class Reader>
std::uint64_t follow(Reader& reader, std::uint64_t end, std::uint64_t pause_every, std::uint64_t& taken) {
  std::uint64_t faults = 0;
  std::uint64_t next = 0;
  std::uint64_t lost_in_all = 0;
  while (next < end) {
    Message message;
    std::uint32_t lost = 0;
    const Status status = reader.read(message, lost);
    next += lost;
    lost_in_all += lost;
    if (status != Status::ok) {
      std::this_thread::yield();
      continue;
    }
    if (message.words[0] != next || !intact(message)) ++faults;
    ++next;
    if (++taken % pause_every == 0) std::this_thread::yield();
  }
  if (next != end || taken + lost_in_all != end || reader.lost() != lost_in_all) ++faults;
  return faults;
}

}  // namespace

TEST_CASE("an overwriting ring keeps the newest elements for each reader, also where its positions wrap") {
  CHECK(against_lists<2>(0, 1) > 5000);
  CHECK(against_lists<4>(0xffffff00u, 2) > 2000);
  CHECK(against_lists<64>(0xffffff00u, 3) > 100);
}

TEST_CASE("a reader that begins late begins with the oldest element kept and has lost nothing") {
  OverwriteRing<int, 4> ring;
  using Reader = OverwriteRing<int, 4>::Reader;
  int value = -1;
  std::uint32_t lost = 99;
  Reader early(ring);
  CHECK(early.read(value, lost) == Status::empty);
  CHECK(value == -1);
  CHECK(lost == 0);
  ring.push(0);
  ring.push(1);
  Reader second(ring);
  REQUIRE(second.read(value, lost) == Status::ok);
  CHECK(value == 0);
  for (int i = 2; i < 10; ++i) ring.push(i);
  CHECK(ring.pushed() == 10);
  Reader late(ring);
  REQUIRE(late.read(value, lost) == Status::ok);
  CHECK(value == 7);
  CHECK(lost == 0);
  REQUIRE(early.read(value, lost) == Status::ok);
  CHECK(value == 7);
  CHECK(lost == 7);
  REQUIRE(second.read(value, lost) == Status::ok);
  CHECK(value == 7);
  CHECK(lost == 6);
}

TEST_CASE(
    "an overwriting ring between threads tears, doubles and reorders nothing and counts what it loses") {
  constexpr std::uint64_t kMessages = 100000;
  static OverwriteRing<Message, 64> ring(0xffff0000u);  // the positions wrap on the way
  using Reader = OverwriteRing<Message, 64>::Reader;
  std::array<std::unique_ptr<Reader>, 3> readers;
  for (auto& reader : readers) reader = std::make_unique<Reader>(ring);
  std::array<std::uint64_t, 3> faults{};
  std::array<std::uint64_t, 3> taken{};
  std::thread producer([] {
    std::mt19937_64 engine(31);
    for (std::uint64_t i = 0; i < kMessages; ++i) {
      ring.push(make_message(i));
      if (engine() % 64 == 0) std::this_thread::yield();
    }
  });
  std::thread fast([&] { faults[0] = follow(*readers[0], kMessages, 1000, taken[0]); });
  std::thread slow([&] { faults[1] = follow(*readers[1], kMessages, 1, taken[1]); });
  producer.join();
  fast.join();
  slow.join();
  faults[2] = follow(*readers[2], kMessages, 1000, taken[2]);
  CHECK(faults == std::array<std::uint64_t, 3>{});
  CHECK(taken[2] == 63);
  CHECK(readers[2]->lost() == kMessages - 63);
}

}  // namespace sortie::rt
