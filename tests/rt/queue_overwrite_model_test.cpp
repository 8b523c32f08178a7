// SPDX-License-Identifier: BSD-3-Clause
// The overwriting ring in every interleaving of a producer and a reader, under the memory model of C++. Each
// rule of the protocol is broken once, and must be missed. Readers share nothing that they write: one stands
// for all.
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>

#include "rt/overwrite_ring.hpp"
#include "tests/rt/model_memory.hpp"

namespace sortie::rt::test {
namespace {

// Two words that belong together.
struct Pair {
  std::uint32_t number{};
  std::uint32_t twin{};
};

enum class RingSlip {
  none,               // as it should be: shows that it is the slip that is caught
  no_second_look,     // believes what it copied
  no_spare_slot,      // believes in the slot that is being written
  counts_first,       // counts an element before it is there
  words_are_relaxed,  // lets a word be seen before the count of the element before it
};

// The ring once more, as short as possible, with a slip.
template <std::uint32_t N, RingSlip slip>
class RingVariant {
 public:
  explicit RingVariant(std::uint32_t first_index) : first(first_index), written(first_index) {}

  void push(const Pair& value) {
    const std::uint32_t position = written.load(std::memory_order_relaxed);
    const auto order =
        slip == RingSlip::words_are_relaxed ? std::memory_order_relaxed : std::memory_order_release;
    if (slip == RingSlip::counts_first) written.store(position + 1, std::memory_order_release);
    words[position % N * 2].store(value.number, order);
    words[position % N * 2 + 1].store(value.twin, order);
    if (slip != RingSlip::counts_first) written.store(position + 1, std::memory_order_release);
  }

  class Reader {
   public:
    explicit Reader(const RingVariant& ring) : ring_(&ring), next_(ring.first) {}

    Status read(Pair& value, std::uint32_t& lost) {
      constexpr std::uint32_t kKept = slip == RingSlip::no_spare_slot ? N : N - 1;
      lost = 0;
      const std::uint32_t waiting = ring_->written.load(std::memory_order_acquire) - next_;
      if (waiting == 0) return Status::empty;
      if (waiting > kKept) {
        lost = waiting - kKept;
        next_ += lost;
      }
      const Pair copy{ring_->words[next_ % N * 2].load(std::memory_order_acquire),
                      ring_->words[next_ % N * 2 + 1].load(std::memory_order_acquire)};
      const std::uint32_t now = ring_->written.load(std::memory_order_relaxed);
      if (slip != RingSlip::no_second_look && now - next_ > kKept) return Status::stale;
      value = copy;
      ++next_;
      return Status::ok;
    }

   private:
    const RingVariant* ring_;
    std::uint32_t next_;
  };

  std::uint32_t first;
  Modelled<std::uint32_t> written;
  Modelled<std::uint32_t> words[N * 2];
};

// A producer that makes room by taking the oldest element away: it becomes a second consumer.
template <std::uint32_t N>
class TakesTheOldest {
 public:
  explicit TakesTheOldest(std::uint32_t first_index) : read_(first_index), written_(first_index) {}

  void push(const Pair& value) {
    const std::uint32_t position = written_.load(std::memory_order_relaxed);
    if (position - read_.load(std::memory_order_acquire) == N) read_.fetch_add(1, std::memory_order_acq_rel);
    words_[position % N * 2].store(value.number, std::memory_order_release);
    words_[position % N * 2 + 1].store(value.twin, std::memory_order_release);
    written_.store(position + 1, std::memory_order_release);
  }

  class Reader {
   public:
    explicit Reader(TakesTheOldest& ring) : ring_(&ring) {}

    Status read(Pair& value, std::uint32_t& lost) {
      const std::uint32_t position = ring_->read_.load(std::memory_order_acquire);
      lost = position - next_;
      if (position == ring_->written_.load(std::memory_order_acquire)) return Status::empty;
      value = {ring_->words_[position % N * 2].load(std::memory_order_acquire),
               ring_->words_[position % N * 2 + 1].load(std::memory_order_acquire)};
      ring_->read_.fetch_add(1, std::memory_order_acq_rel);
      next_ = position + 1;
      return Status::ok;
    }

   private:
    TakesTheOldest* ring_;
    std::uint32_t next_{0};
  };

 private:
  Modelled<std::uint32_t> read_;
  Modelled<std::uint32_t> written_;
  Modelled<std::uint32_t> words_[N * 2];
};

// The producer pushes 1, 2, 3, ...; the reader reads `reads` times, and the rest after the end. Every element
// must be taken whole and in order, or be counted as lost, and the newest must be there in the end.
template <class Ring>
Result overwriting(std::uint32_t pushes, int reads, std::uint32_t first_index, bool stop_at_failure) {
  std::unique_ptr<Ring> ring;
  std::unique_ptr<typename Ring::Reader> reader;
  std::uint32_t accounted = 0;
  Explorer& explorer = Explorer::instance();
  const auto look = [&] {
    Pair value{77, 77};
    std::uint32_t lost = 0;
    const Status status = reader->read(value, lost);
    accounted += lost;
    if (status != Status::ok) {
      if (value.number != 77 || value.twin != 77) explorer.fail();
      return false;
    }
    if (value.number != ++accounted || value.twin != ~value.number) explorer.fail();
    return true;
  };
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>(first_index);
        reader = std::make_unique<typename Ring::Reader>(*ring);
        accounted = 0;
      },
      [&] {
        for (std::uint32_t i = 1; i <= pushes; ++i) ring->push({i, ~i});
      },
      [&] {
        for (int i = 0; i < reads; ++i) look();
      },
      [&] {
        for (std::uint32_t i = 0; i <= pushes; ++i) {
          if (!look()) break;
        }
        if (accounted != pushes) explorer.fail();
      },
      stop_at_failure);
  return {executions, explorer.failures()};
}

// The producer pushes 1, 2, 3, ...; the reader asks `reads` times for the newest, without a position of its
// own. It is whole, or refused, and never runs backwards.
Result newest(std::uint32_t pushes, int reads, bool stop_at_failure) {
  using Ring = OverwriteRing<Pair, 2, Modelled>;
  std::unique_ptr<Ring> ring;
  std::uint32_t last = 0;
  Explorer& explorer = Explorer::instance();
  const std::uint64_t executions = explorer.explore(
      [&] {
        ring = std::make_unique<Ring>();
        last = 0;
      },
      [&] {
        for (std::uint32_t i = 1; i <= pushes; ++i) ring->push({i, ~i});
      },
      [&] {
        for (int i = 0; i < reads; ++i) {
          const std::uint32_t end = ring->end();
          Pair value{77, 77};
          if (end == 0) continue;
          if (!ring->copy(end - 1, value)) {
            if (value.number != 77 || value.twin != 77) explorer.fail();
            continue;
          }
          if (value.number != end || value.twin != ~end || end < last) explorer.fail();
          last = end;
        }
      },
      [] {}, stop_at_failure);
  return {executions, explorer.failures()};
}

constexpr std::uint32_t kLastPosition = 0xffffffffu;

}  // namespace

TEST_CASE("the overwriting ring gives every element whole and once or counts it as lost in any interleaving",
          "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const Result two = overwriting<OverwriteRing<Pair, 2, Modelled>>(3, 2, kLastPosition, false);
  const Result four = overwriting<OverwriteRing<Pair, 4, Modelled>>(5, 1, 0, false);
  INFO(two.executions << ", " << four.executions << " executions");
  CHECK(two.executions > 1000);
  CHECK(four.executions > 1000);
  CHECK(two.failures == 0);
  CHECK(four.failures == 0);
}

TEST_CASE("each slip in an overwriting ring is caught") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  CHECK(overwriting<RingVariant<2, RingSlip::none>>(3, 2, 0, false).failures == 0);
  CHECK(overwriting<RingVariant<2, RingSlip::no_second_look>>(3, 2, 0, true).failures > 0);
  CHECK(overwriting<RingVariant<2, RingSlip::no_spare_slot>>(3, 2, 0, true).failures > 0);
  CHECK(overwriting<RingVariant<2, RingSlip::counts_first>>(3, 2, 0, true).failures > 0);
  CHECK(overwriting<RingVariant<2, RingSlip::words_are_relaxed>>(3, 2, 0, true).failures > 0);
}

TEST_CASE("each memory order of the overwriting ring is needed, and its loss is caught", "[model]") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  const OrderPlants plants = weaken_each_order([](bool stop) {
    return overwriting<OverwriteRing<Pair, 2, Modelled>>(3, 2, 0, stop) + newest(3, 2, stop);
  });
  CHECK(plants.as_it_is.failures == 0);
  CHECK(plants.missed == Names{});
  CHECK(plants.caught == Names{"end: load acquire", "load_words: load acquire", "push: store release",
                               "store_words: store release"});
}

TEST_CASE("an overwriting ring whose producer takes the oldest element away is caught") {
  SORTIE_SKIP_WITHOUT_FIBRES();
  CHECK(overwriting<TakesTheOldest<2>>(3, 2, 0, true).failures > 0);
}

}  // namespace sortie::rt::test
