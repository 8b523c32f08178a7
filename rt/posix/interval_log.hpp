// SPDX-License-Identifier: BSD-3-Clause
// Intervals of time that one thread notes and real-time threads look up without waiting.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "rt/overwrite_ring.hpp"
#include "rt/time.hpp"

namespace sortie::rt::posix {

/// The newest N - 1 intervals with a weight each: one writer, any number of readers, no lock, fixed memory
/// (1.5 kB). A reader that is overtaken sees less, never something wrong. `Atomic`: as of OverwriteRing.
template <std::uint32_t N = 64, template <class> class Atomic = std::atomic>
class BasicIntervalLog {
 public:
  static constexpr std::uint32_t kSlots = N;

  void add(Nanoseconds begin, Nanoseconds end, std::uint64_t weight) noexcept {
    ring_.push({begin, end, weight});
  }
  /// Nothing but what was added happened until then [ns].
  void cover(Nanoseconds until) noexcept { covered_until_.store(until, std::memory_order_release); }
  /// Whoever asks for this first, and for the intervals then, misses none before it.
  Nanoseconds covered_until() const noexcept { return covered_until_.load(std::memory_order_acquire); }

  /// Time within [begin, end] that lies in any of the intervals, which must not overlap.
  Nanoseconds overlap(Nanoseconds begin, Nanoseconds end) const noexcept {
    Nanoseconds sum = 0;
    for_each([&](const Interval& held) {
      sum += std::max(Nanoseconds{0}, std::min(end, held.end) - std::max(begin, held.begin));
    });
    return sum;
  }

  /// Sum of the weights of the intervals that touch [begin, end].
  std::uint64_t weight(Nanoseconds begin, Nanoseconds end) const noexcept {
    std::uint64_t sum = 0;
    for_each([&](const Interval& held) {
      if (held.begin < end && held.end > begin) sum += held.weight;
    });
    return sum;
  }

 private:
  struct Interval {
    Nanoseconds begin{};
    Nanoseconds end{};
    std::uint64_t weight{};
  };

  // Newest first, up to the first that the writer may be filling again.
  template <class F>
  void for_each(F f) const noexcept {
    const std::uint32_t count = ring_.end();
    Interval held;
    for (std::uint32_t back = 1; back <= std::min(count, N); ++back) {
      if (!ring_.copy(count - back, held)) return;
      f(held);
    }
  }

  OverwriteRing<Interval, N, Atomic> ring_;
  Atomic<Nanoseconds> covered_until_{0};
};

using IntervalLog = BasicIntervalLog<>;

}  // namespace sortie::rt::posix
