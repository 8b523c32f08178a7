// SPDX-License-Identifier: BSD-3-Clause
// When the newest samples of a stream arrived, by sequence number: chains are measured from there.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "rt/time.hpp"

namespace sortie::firmware {

/// The arrival times of the last `capacity` samples (a power of two). One thread notes, one other may look up
/// what it knows to have been noted; a time that has been overwritten meanwhile is not found. `Atomic` is
/// std::atomic, or its twin in the model that takes the memory orders away one by one.
template <template <class> class Atomic = std::atomic>
class BasicArrivals {
 public:
  explicit BasicArrivals(std::uint32_t capacity) : times_(capacity) {}

  /// Producer: sample `sequence` arrived at `received_ns`. Numbers rise by one; the newest may come again.
  void note(std::uint64_t sequence, rt::Nanoseconds received_ns) {
    if (end_.load(std::memory_order_relaxed) == 0) first_.store(sequence, std::memory_order_relaxed);
    // Whoever sees the new time also sees that the number before it was the newest: the old one is gone then.
    times_[slot(sequence)].store(received_ns, std::memory_order_release);
    end_.store(sequence + 1, std::memory_order_release);
  }

  /// Number of the first sample that was noted: 0, or where a replay began. Known once anything is noted.
  std::uint64_t first() const { return first_.load(std::memory_order_relaxed); }

  /// False when that sample is unknown or too long ago.
  bool find(std::uint64_t sequence, rt::Nanoseconds& received_ns) const {
    if (sequence >= end_.load(std::memory_order_acquire) || sequence < first()) return false;
    received_ns = times_[slot(sequence)].load(std::memory_order_acquire);
    return end_.load(std::memory_order_relaxed) < sequence + times_.size();
  }

 private:
  std::size_t slot(std::uint64_t sequence) const {
    return static_cast<std::size_t>(sequence & (times_.size() - 1));
  }

  std::vector<Atomic<rt::Nanoseconds>> times_;
  Atomic<std::uint64_t> first_{};
  Atomic<std::uint64_t> end_{};
};

using Arrivals = BasicArrivals<>;

}  // namespace sortie::firmware
