// SPDX-License-Identifier: BSD-3-Clause
// Ring and mailbox: against a plain list on one thread, and under load on two. ThreadSanitizer builds run the
// same.
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <random>
#include <span>
#include <thread>
#include <vector>

#include "rt/mailbox.hpp"
#include "rt/spsc_ring.hpp"
#include "tests/rt/queue_message.hpp"

namespace sortie::rt {
namespace {

using test::intact;
using test::make_message;
using test::Message;

// Three words: a size that is no power of two.
struct Odd {
  Odd(int number = 0) : first(number), last(number) {}  // NOLINT: stands for a number
  friend bool operator==(const Odd&, const Odd&) = default;
  std::int32_t first;
  std::int32_t middle{7};
  std::int32_t last;
};

// How often a random run met either end of the ring: one that never did would prove little.
struct Ends {
  int full{};
  int empty{};
};

// Random single, batched and in-place calls, compared with std::deque after each. `Element` is made of an
// int.
template <class Element, class Ring>
Ends against_deque(Ring& ring, std::uint64_t seed) {
  Ends ends;
  std::mt19937_64 engine(seed);
  std::deque<int> twin;
  const auto capacity = static_cast<std::size_t>(ring.capacity());
  int next = 0;
  INFO("seed " << seed);
  for (int step = 0; step < 20000; ++step) {
    std::array<Element, 20> batch{};
    const auto wanted = static_cast<std::uint32_t>(engine() % batch.size());
    switch (engine() % 6) {
      case 0: {
        const bool pushed = ring.try_push(next);
        REQUIRE(pushed == (twin.size() < capacity));
        if (pushed) twin.push_back(next++);
        break;
      }
      case 1: {
        Element value = -1;
        const bool popped = ring.try_pop(value);
        REQUIRE(popped == !twin.empty());
        REQUIRE(value == (popped ? twin.front() : -1));
        if (popped) twin.pop_front();
        break;
      }
      case 2: {
        for (std::uint32_t i = 0; i < wanted; ++i) batch[i] = next + static_cast<int>(i);
        const std::uint32_t pushed = ring.push_n(batch.data(), wanted);
        REQUIRE(pushed == std::min<std::size_t>(wanted, capacity - twin.size()));
        for (std::uint32_t i = 0; i < pushed; ++i) twin.push_back(next++);
        break;
      }
      case 3: {
        const std::span<Element> free = ring.claim(wanted);
        REQUIRE(free.size() <= std::min<std::size_t>(wanted, capacity - twin.size()));
        REQUIRE((free.empty() ? wanted == 0 || twin.size() == capacity : true));
        for (std::size_t i = 0; i < free.size(); ++i) free[i] = next + static_cast<int>(i);
        const auto published = static_cast<std::uint32_t>(engine() % (free.size() + 1));
        ring.publish(published);  // not always all that was claimed
        for (std::uint32_t i = 0; i < published; ++i) twin.push_back(next++);
        break;
      }
      case 4: {
        const std::span<const Element> oldest = ring.peek(wanted);
        REQUIRE(oldest.size() <= std::min<std::size_t>(wanted, twin.size()));
        REQUIRE((oldest.empty() ? wanted == 0 || twin.empty() : true));
        for (std::size_t i = 0; i < oldest.size(); ++i) REQUIRE(oldest[i] == twin[i]);
        const auto released = static_cast<std::uint32_t>(engine() % (oldest.size() + 1));
        ring.release(released);
        twin.erase(twin.begin(), twin.begin() + static_cast<std::ptrdiff_t>(released));
        break;
      }
      default: {
        const std::uint32_t popped = ring.pop_n(batch.data(), wanted);
        REQUIRE(popped == std::min<std::size_t>(wanted, twin.size()));
        for (std::uint32_t i = 0; i < popped; ++i) {
          REQUIRE(batch[i] == twin.front());
          twin.pop_front();
        }
      }
    }
    REQUIRE(ring.size() == twin.size());
    ends.full += twin.size() == capacity ? 1 : 0;
    ends.empty += twin.empty() ? 1 : 0;
  }
  return ends;
}

}  // namespace

TEST_CASE("a ring behaves as a bounded list, also where its indices wrap") {
  const auto met_both_ends = [](const Ends& ends) { return ends.full > 1000 && ends.empty > 1000; };
  SpscRing<int, 1> one;
  CHECK(met_both_ends(against_deque<int>(one, 1)));
  SpscRing<int, 8> eight;
  CHECK(met_both_ends(against_deque<int>(eight, 2)));
  SpscRing<int, 16> wrapping(0xffffff00u);
  CHECK(met_both_ends(against_deque<int>(wrapping, 3)));
  std::array<int, 32> slots{};
  SpscSpanRing<int> spanned(slots.data(), 32);
  CHECK(met_both_ends(against_deque<int>(spanned, 4)));
  SpscRing<Odd, 16> odd(0xffffff00u);
  CHECK(met_both_ends(against_deque<Odd>(odd, 5)));
  std::array<Odd, 4> odd_slots{};
  SpscSpanRing<Odd> odd_spanned(odd_slots.data(), 4);
  CHECK(met_both_ends(against_deque<Odd>(odd_spanned, 6)));
}

TEST_CASE("a ring over external memory takes powers of two only, and only once") {
  std::array<int, 8> slots{};
  SpscSpanRing<int> ring;
  int value = 0;
  CHECK(ring.capacity() == 0);
  CHECK_FALSE(ring.try_push(1));
  CHECK_FALSE(ring.try_pop(value));
  CHECK(ring.push_n(slots.data(), 3) == 0);
  CHECK(ring.pop_n(slots.data(), 3) == 0);
  CHECK(ring.claim(3).empty());
  CHECK(ring.peek(3).empty());
  ring.publish(3);
  ring.release(3);
  CHECK(ring.size() == 0);
  CHECK_FALSE(ring.attach(slots.data(), 0));
  CHECK_FALSE(ring.attach(slots.data(), 6));
  CHECK_FALSE(ring.attach(nullptr, 8));
  CHECK_FALSE(ring.attach(slots.data(), 0x40000000u));  // 4 GiB of int
  CHECK(ring.attach(slots.data(), 8));
  CHECK_FALSE(ring.attach(slots.data(), 4));
  CHECK(ring.capacity() == 8);
  CHECK(ring.try_push(5));
  CHECK(ring.try_pop(value));
  CHECK(value == 5);
}

TEST_CASE("a ring publishes no more than is free and releases no more than is there") {
  SpscRing<int, 4> ring;
  REQUIRE(ring.claim(4).size() == 4);
  ring.publish(9);
  CHECK(ring.size() == 4);
  REQUIRE(ring.peek(2).size() == 2);
  ring.release(9);
  CHECK(ring.size() == 0);
  CHECK(ring.claim(9).size() == 4);
}

TEST_CASE("a ring between two threads loses, doubles and tears nothing") {
  constexpr std::uint64_t kMessages = 200000;
  static SpscRing<Message, 64> ring(0xffff0000u);  // the indices wrap on the way
  std::uint64_t sum_in = 0;
  std::thread producer([&sum_in] {
    std::mt19937_64 engine(21);
    std::array<Message, 16> batch;
    std::uint64_t next = 0;
    while (next < kMessages) {
      const std::uint64_t wanted = std::min<std::uint64_t>(1 + engine() % 16, kMessages - next);
      for (std::size_t i = 0; i < wanted; ++i) batch[i] = make_message(next + i);
      std::uint32_t done = 0;
      if (wanted == 1) {
        done = ring.try_push(batch[0]) ? 1 : 0;
      } else {
        done = ring.push_n(batch.data(), static_cast<std::uint32_t>(wanted));
      }
      for (std::uint32_t i = 0; i < done; ++i) sum_in += batch[i].words[8];
      next += done;
      if (done == 0) std::this_thread::yield();
    }
  });
  std::mt19937_64 engine(22);
  std::array<Message, 16> batch;
  std::uint64_t next = 0;
  std::uint64_t sum_out = 0;
  std::uint64_t faults = 0;
  while (next < kMessages) {
    const auto wanted = static_cast<std::uint32_t>(1 + engine() % 16);
    const std::uint32_t done =
        wanted == 1 ? (ring.try_pop(batch[0]) ? 1u : 0u) : ring.pop_n(batch.data(), wanted);
    for (std::uint32_t i = 0; i < done; ++i) {
      if (batch[i].words[0] != next || !intact(batch[i])) ++faults;
      sum_out += batch[i].words[8];
      ++next;
    }
    if (ring.size() > ring.capacity()) ++faults;
    if (done == 0) std::this_thread::yield();
  }
  producer.join();
  CHECK(faults == 0);
  CHECK(sum_in == sum_out);
  CHECK(ring.size() == 0);
}

TEST_CASE("a mailbox between two threads is never torn and never runs backwards") {
  constexpr std::uint64_t kMessages = 100000;
  static Mailbox<Message> box;
  box.write(make_message(0));
  std::thread writer([] {
    for (std::uint64_t i = 1; i <= kMessages; ++i) {
      box.write(make_message(i));
      if (i % 64 == 0) std::this_thread::yield();
    }
  });
  std::uint64_t faults = 0;
  std::uint64_t last = 0;
  std::uint64_t fresh_reads = 0;
  while (last < kMessages) {
    Message message;
    const bool fresh = box.read(message);
    if (!intact(message)) ++faults;
    if (fresh ? message.words[0] < last : message.words[0] != last) ++faults;
    fresh_reads += fresh ? 1 : 0;
    last = message.words[0];
    if (!fresh) std::this_thread::yield();
  }
  writer.join();
  CHECK(faults == 0);
  CHECK(fresh_reads > 0);
  CHECK_FALSE(box.refresh());
}

TEST_CASE("a mailbox gives the newest value once as fresh, and keeps it") {
  Mailbox<int> box;
  int value = -1;
  CHECK_FALSE(box.read(value));
  CHECK(value == 0);
  box.write(1);
  box.write(2);
  CHECK(box.read(value));
  CHECK(value == 2);
  CHECK_FALSE(box.read(value));
  CHECK(value == 2);
  box.draft() = 3;
  CHECK_FALSE(box.read(value));
  box.publish();
  CHECK(box.refresh());
  CHECK(box.value() == 3);
}

}  // namespace sortie::rt
