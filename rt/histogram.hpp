// SPDX-License-Identifier: BSD-3-Clause
// Distribution of durations in fixed memory: worst case and percentiles of every task, always on.
//
// Log-linear buckets: exact below 64 ns, then 64 equal ones per doubling, each at most 1/64 (1.6 %) of its
// value wide, up to 2^36 ns (68.7 s). Longer ones share a last bucket; min, max, count and sum are exact.
#pragma once

#include <bit>
#include <cstdint>

#include "rt/limits.hpp"

namespace sortie::rt {

/// Histogram of durations in nanoseconds. One thread writes; a reader needs that thread stopped, or its own
/// copy. Memory: 15.9 kB inline, no heap (0.6 kB in steps of 50 % on a small board, rt/limits.hpp).
class LatencyHistogram {
 public:
  /// Buckets per doubling, as a power of two.
  static constexpr std::uint32_t kSubBits = kHistogramSubBits;
  /// Durations from here on share the last bucket.
  static constexpr std::uint64_t kOverflowNs = 1ull << 36;
  /// Number of buckets, the overflow bucket included.
  static constexpr std::uint32_t kBuckets = (36 - kSubBits + 1) * (1u << kSubBits) + 1;

  /// Counts one duration. A handful of instructions, no branch that depends on it but the clamp.
  void record(std::uint64_t ns) { record_many(ns, 1); }

  /// Counts one duration `times` times.
  void record_many(std::uint64_t ns, std::uint64_t times) {
    if (times == 0) return;
    buckets_[index_of(ns)] += times;
    count_ += times;
    sum_ += ns * times;
    min_ = ns < min_ ? ns : min_;
    max_ = ns > max_ ? ns : max_;
  }

  /// Durations recorded.
  std::uint64_t count() const { return count_; }
  /// Sum of all durations [ns], modulo 2^64 (584 years).
  std::uint64_t sum() const { return sum_; }
  /// Shortest duration [ns], 0 when none.
  std::uint64_t min() const { return count_ == 0 ? 0 : min_; }
  /// Longest duration [ns], 0 when none.
  std::uint64_t max() const { return max_; }
  /// Mean duration [ns], 0 when none.
  double mean() const { return count_ == 0 ? 0.0 : static_cast<double>(sum_) / static_cast<double>(count_); }

  /// The duration [ns] that a share `q` (0..1, clamped; 0.999 = p99.9) of all does not exceed: the upper edge
  /// of the bucket that holds the element of rank ceil(q * count), never above max(). So it is never too
  /// small and at most 1/64 too large. 0 when empty. Cost: one pass over the buckets.
  std::uint64_t percentile(double q) const {
    if (count_ == 0) return 0;
    const double share = q > 0.0 ? (q < 1.0 ? q : 1.0) : 0.0;  // a NaN becomes 0
    // 0.07 * 100 is a hair above 7 in binary; the factor keeps such products off the next rank.
    const double exact = share * static_cast<double>(count_) * (1.0 - 0x1p-50);
    std::uint64_t rank = static_cast<std::uint64_t>(exact);
    if (static_cast<double>(rank) < exact) ++rank;
    if (rank == 0) rank = 1;
    if (rank >= count_) return max_;
    std::uint64_t seen = 0;
    for (std::uint32_t i = 0; i < kBuckets - 1; ++i) {
      seen += buckets_[i];
      if (seen >= rank) return high_of(i) < max_ ? high_of(i) : max_;
    }
    return max_;
  }

  /// Adds all that `other` has counted, as if it had been recorded here. Cost: one pass over the buckets.
  void merge(const LatencyHistogram& other) {
    for (std::uint32_t i = 0; i < kBuckets; ++i) buckets_[i] += other.buckets_[i];
    count_ += other.count_;
    sum_ += other.sum_;
    min_ = other.min_ < min_ ? other.min_ : min_;
    max_ = other.max_ > max_ ? other.max_ : max_;
  }

  /// Forgets everything.
  void clear() { *this = LatencyHistogram{}; }

  /// Calls f(low_ns, high_ns, count) for each bucket that is not empty, in rising order; both edges belong to
  /// the bucket. The overflow bucket's upper edge is max().
  template <class F>
  void for_each_bucket(F&& f) const {
    for (std::uint32_t i = 0; i < kBuckets; ++i) {
      if (buckets_[i] == 0) continue;
      f(low_of(i), i == kBuckets - 1 ? max_ : high_of(i), std::uint64_t{buckets_[i]});
    }
  }

 private:
  static constexpr std::uint32_t index_of(std::uint64_t ns) {
    if (ns >= kOverflowNs) return kBuckets - 1;
    // The `|` makes the scale of values below 64 zero: they are their own index.
    const std::uint32_t scale =
        static_cast<std::uint32_t>(std::bit_width(ns | (1ull << kSubBits))) - (kSubBits + 1);
    return (scale << kSubBits) + static_cast<std::uint32_t>(ns >> scale);
  }
  static constexpr std::uint64_t low_of(std::uint32_t index) {
    if (index < (2u << kSubBits)) return index;
    const std::uint32_t scale = (index >> kSubBits) - 1;
    return (std::uint64_t{index & ((1u << kSubBits) - 1)} + (1u << kSubBits)) << scale;
  }
  static constexpr std::uint64_t high_of(std::uint32_t index) { return low_of(index + 1) - 1; }

  std::uint64_t buckets_[kBuckets]{};
  std::uint64_t count_{0};
  std::uint64_t sum_{0};
  std::uint64_t min_{~0ull};
  std::uint64_t max_{0};
};

}  // namespace sortie::rt
