// SPDX-License-Identifier: BSD-3-Clause
// Pooled buffers: a buffer that a job sees is never the producer's, in any order of events and under load. A
// stream that gives its buffers back too early must be caught.
#include <catch2/catch.hpp>
#include <cstdint>
#include <deque>
#include <random>
#include <thread>
#include <vector>

#include "rt/pooled_stream.hpp"
#include "tests/rt/queue_message.hpp"

namespace sortie::rt {
namespace {

using test::scramble;

struct Head {
  std::uint64_t number{};
  std::uint32_t points{};

  template <class Self, class Visitor>
  static constexpr void fields(Self& self, Visitor&& visit) {
    visit("number", self.number);
    visit("points", self.points);
  }
};

constexpr std::uint32_t kRing = 8;
constexpr std::uint32_t kSlots = 6;
constexpr std::uint32_t kSlotSize = 5;
constexpr std::uint32_t kBatchSize = 3;

// The stream with its memory.
struct Pooled {
  using Stream = PooledStream<Head, std::uint64_t>;

  std::uint64_t* reserve(std::uint32_t count) { return stream.reserve(count); }
  Status commit(const Head& head) { return stream.commit(head); }
  void cancel() { stream.cancel(); }
  void latch(std::uint32_t limit) {
    StreamRange range{};
    stream.latch(++tick, limit, range);
  }
  std::uint32_t size() const { return stream.size(); }
  Stream::View operator[](std::uint32_t index) const { return stream[index]; }
  std::uint32_t waiting() const { return stream.waiting(); }

  std::uint64_t elements[kSlots * kSlotSize]{};
  Stream::Ticket tickets[kRing]{};
  std::uint32_t free_slots[kRing]{};
  Stream::Ticket batch[kBatchSize]{};
  Tick tick{0};
  Stream stream{"scans", 0, elements, kSlots, kSlotSize, tickets, free_slots, kRing, batch, kBatchSize};
};

// The same from the outside, but a buffer is free again as soon as a job has taken it.
class RetiresAtOnce {
 public:
  RetiresAtOnce() {
    for (std::uint32_t slot = 0; slot < kSlots; ++slot) free_.push_back(slot);
  }
  std::uint64_t* reserve(std::uint32_t count) {
    if (count > kSlotSize || free_.empty()) return nullptr;
    return elements_ + static_cast<std::size_t>(free_.front()) * kSlotSize;
  }
  Status commit(const Head& head) {
    ready_.push_back({head, free_.front()});
    free_.pop_front();
    return Status::ok;
  }
  void cancel() {}
  void latch(std::uint32_t limit) {
    batch_.clear();
    while (batch_.size() < limit && batch_.size() < kBatchSize && !ready_.empty()) {
      batch_.push_back(ready_.front());
      free_.push_front(ready_.front().slot);
      ready_.pop_front();
    }
  }
  std::uint32_t size() const { return static_cast<std::uint32_t>(batch_.size()); }
  Pooled::Stream::View operator[](std::uint32_t index) const {
    return {batch_[index].header, elements_ + static_cast<std::size_t>(batch_[index].slot) * kSlotSize};
  }
  std::uint32_t waiting() const { return static_cast<std::uint32_t>(ready_.size()); }

 private:
  using Ticket = Pooled::Stream::Ticket;
  std::uint64_t elements_[kSlots * kSlotSize]{};
  std::deque<std::uint32_t> free_;
  std::deque<Ticket> ready_;
  std::vector<Ticket> batch_;
};

void fill(std::uint64_t* elements, const Head& head) {
  for (std::uint32_t i = 0; i < head.points; ++i) elements[i] = scramble(head.number * 8 + i);
}

bool intact(const Pooled::Stream::View& view) {
  for (std::uint32_t i = 0; i < view.header.points; ++i) {
    if (view.elements[i] != scramble(view.header.number * 8 + i)) return false;
  }
  return true;
}

// Calls in random order on one thread; after each, what the job sees must be whole and in order. Returns the
// number of faults.
template <class Stream>
std::uint64_t in_any_order(Stream& stream, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uint64_t faults = 0;
  std::uint64_t committed = 0;
  std::uint64_t first_seen = 0;
  std::uint64_t seen_until = 0;
  std::uint64_t refused = 0;
  for (int step = 0; step < 20000; ++step) {
    if (engine() % 3 != 0) {
      const Head head{committed, static_cast<std::uint32_t>(engine() % (kSlotSize + 1))};
      std::uint64_t* const room = stream.reserve(head.points);
      // Buffers are refused only when all of them wait or are seen.
      if (room == nullptr) {
        ++refused;
        if (stream.waiting() + stream.size() < kSlots) ++faults;
      } else {
        fill(room, head);
        if (engine() % 4 == 0) {
          stream.cancel();
        } else {
          if (stream.commit(head) != Status::ok) ++faults;
          ++committed;
        }
      }
    } else {
      stream.latch(static_cast<std::uint32_t>(engine() % 4));
      first_seen = seen_until;
      seen_until += stream.size();
    }
    for (std::uint32_t i = 0; i < stream.size(); ++i) {
      if (stream[i].header.number != first_seen + i || !intact(stream[i])) ++faults;
    }
    if (stream.waiting() != committed - seen_until) ++faults;
  }
  if (refused == 0 || seen_until < 1000) ++faults;  // the test must have reached both
  return faults;
}

}  // namespace

TEST_CASE(
    "a pooled buffer that a job sees is never written again before the next job in any order of calls") {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Pooled pooled;
    INFO("seed " << seed);
    CHECK(in_any_order(pooled, seed) == 0);
  }
}

TEST_CASE("a stream that gives its pooled buffers back as soon as they are taken is caught") {
  RetiresAtOnce wrong;
  CHECK(in_any_order(wrong, 1) > 0);
}

TEST_CASE("pooled buffers between two threads lose, double and tear nothing") {
  constexpr std::uint64_t kSamples = 5000;
  static Pooled pooled;
  std::thread producer([] {
    std::mt19937_64 engine(51);
    for (std::uint64_t number = 0; number < kSamples;) {
      const Head head{number, static_cast<std::uint32_t>(engine() % (kSlotSize + 1))};
      std::uint64_t* const room = pooled.reserve(head.points);
      if (room == nullptr) {
        std::this_thread::yield();
        continue;
      }
      fill(room, head);
      if (engine() % 16 == 0) {
        pooled.cancel();
      } else if (pooled.commit(head) == Status::ok) {
        ++number;
      }
    }
  });
  std::uint64_t next = 0;
  std::uint64_t faults = 0;
  while (next < kSamples) {
    pooled.latch(kBatchSize);
    for (std::uint32_t i = 0; i < pooled.size(); ++i) {
      if (pooled[i].header.number != next + i || !intact(pooled[i])) ++faults;
    }
    if (next % 8 == 0 || pooled.size() == 0) std::this_thread::yield();
    for (std::uint32_t i = 0; i < pooled.size(); ++i) {
      if (!intact(pooled[i])) ++faults;  // still, after the producer had its time
    }
    next += pooled.size();
  }
  producer.join();
  CHECK(faults == 0);
  CHECK(pooled.waiting() == 0);
}

}  // namespace sortie::rt
