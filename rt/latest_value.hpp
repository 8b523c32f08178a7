// SPDX-License-Identifier: BSD-3-Clause
// Latest value from one writer thread to several reader threads: nobody waits, nobody tries twice, nothing is
// torn.
//
// R readers and R + 2 slots: each reader holds one, one is the newest, so one is always free to be written. A
// reader moves on by adding one to the word that names the newest slot: naming it and being counted there is
// one step. The writer takes the count away with the name when it publishes the next value, and writes a slot
// again only when as many readers have left as came. (Counting readers without naming them: Ianni,
// Pellegrini, Quaglia, "A wait-free multi-word atomic (1,N) register for large-scale data sharing on
// multi-core machines", 2017.)
//
// A sequence lock would take one slot, but its readers copy again whenever the writer comes in between,
// without a bound, and only trivially copyable values can be read that way without a data race.
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

#include "rt/cache_line.hpp"

namespace sortie::rt {

/// The newest value of type T for up to kReaders reader threads, from one writer thread. Wait-free on both
/// sides. Which value a reader sees depends on timing: nothing that enters a digest travels in one. Memory:
/// (kReaders + 2) * (sizeof(T) + 8 rounded up to cache lines + 64) + kReaders * 64 + 64 bytes.
template <class T, std::uint32_t kReaders, template <class> class Atomic = std::atomic>
class LatestValue {
  static_assert(kReaders >= 1 && kReaders <= 250, "a slot's number has eight bits");
  static_assert(std::is_nothrow_copy_assignable_v<T>, "values are copied on the real-time path");

 public:
  LatestValue() {
    for (Reader& reader : readers_) reader.box_ = this;
  }
  LatestValue(const LatestValue&) = delete;
  LatestValue& operator=(const LatestValue&) = delete;

  /// Writer: makes a copy the newest value. Cost: one copy, one exchange, at most kReaders + 1 loads.
  void write(const T& value) {
    draft() = value;
    publish();
  }

  /// Writer: a slot to fill in place, for large values. It holds some older value. The same until publish().
  T& draft() {
    if (draft_ == kNone) draft_ = free_slot();
    return slots_[draft_].value;
  }

  /// Writer: makes the draft the newest value.
  void publish() {
    static_cast<void>(draft());
    slots_[draft_].generation = ++generation_;
    // Acquire: a reader that was counted on the old slot has left the one before; free_slot() must know.
    const std::uint32_t old = current_.exchange(draft_, std::memory_order_acq_rel);
    came_[newest_] += old / kOneReader;
    newest_ = draft_;
    draft_ = kNone;
  }

  /// Values ever written. Writer only; a Reader has its own.
  std::uint64_t generation() const { return generation_; }

  /// One reader thread's place.
  class alignas(kCacheLineBytes) Reader {
   public:
    /// Moves on to the newest value. False when there is none newer than the one held: one load. Else two
    /// additions. Never a copy.
    bool refresh() {
      if (box_->current_.load(std::memory_order_relaxed) % kOneReader == held_) return false;
      box_->exits_[held_].left.fetch_add(1, std::memory_order_release);
      held_ = box_->current_.fetch_add(kOneReader, std::memory_order_acq_rel) % kOneReader;
      return true;
    }

    /// The value held since the last refresh(); a default T before the first. Valid until the next refresh().
    const T& value() const { return box_->slots_[held_].value; }

    /// How many values had been written when the one held was: 0 before the first. The step between two reads
    /// tells what was missed.
    std::uint64_t generation() const { return box_->slots_[held_].generation; }

    /// Copies the newest value. True when it is newer than the one read before; `out` is written either way.
    bool read(T& out) {
      const bool fresh = refresh();
      out = value();
      return fresh;
    }

   private:
    friend class LatestValue;
    LatestValue* box_{nullptr};
    std::uint32_t held_{0};
  };

  /// The place of reader number `index`, for one thread at a time; nullptr from kReaders on. Places that
  /// nobody uses do no harm.
  Reader* reader(std::uint32_t index) { return index < kReaders ? readers_ + index : nullptr; }

 private:
  static constexpr std::uint32_t kSlots = kReaders + 2;
  static constexpr std::uint32_t kOneReader = 256;  // above the slot's number: readers that came to it
  static constexpr std::uint32_t kNone = UINT32_MAX;

  struct alignas(kCacheLineBytes) Slot {
    T value{};
    std::uint64_t generation{0};
  };
  struct alignas(kCacheLineBytes) Exit {
    Atomic<std::uint32_t> left{0};  // readers that have left the slot, ever
  };

  // One is free: not the newest, and no reader there. If it is none of the others it is the last.
  std::uint32_t free_slot() const {
    std::uint32_t slot = 0;
    while (slot + 1 < kSlots &&
           (slot == newest_ || exits_[slot].left.load(std::memory_order_acquire) != came_[slot])) {
      ++slot;
    }
    return slot;
  }

  Slot slots_[kSlots]{};
  Exit exits_[kSlots]{};
  Reader readers_[kReaders]{};
  alignas(kCacheLineBytes) Atomic<std::uint32_t> current_{kReaders * kOneReader};  // all start on slot 0
  alignas(kCacheLineBytes) std::uint32_t newest_{0};
  std::uint32_t draft_{kNone};
  std::uint32_t came_[kSlots]{};  // readers that came to a slot while it was the newest; grows when it ends
  std::uint64_t generation_{0};
};

}  // namespace sortie::rt
