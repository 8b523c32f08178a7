// SPDX-License-Identifier: BSD-3-Clause
// Counts of a group's releases that were not met: in all, in a row, and against an (m,k)-firm promise
// (Hamdaoui and Ramanathan, 1995).
#pragma once

#include <bit>
#include <cstdint>

#include "rt/archive.hpp"

namespace sortie::rt {

/// Of any `k` releases in a row at least `m` are met. k = 0: nothing is promised. k <= 64, m <= k.
struct FirmPromise {
  std::uint8_t m{};
  std::uint8_t k{};
};

/// Outcome of the releases of one group. A release that was skipped counts as missed. No heap; a few
/// instructions a release; one thread.
class MissWindow {
 public:
  MissWindow() = default;
  explicit MissWindow(FirmPromise promise) : promise_(promise) {}

  /// Notes one release. True when the promise is broken from this release on (it held before it).
  bool note(bool met) {
    missed_ += met ? 0u : 1u;
    in_row_ = met ? 0 : in_row_ + 1;
    worst_in_row_ = in_row_ > worst_in_row_ ? in_row_ : worst_in_row_;
    history_ = (history_ << 1) | (met ? 0u : 1u);  // bits before the first release say met
    if (promise_.k == 0) return false;
    const std::uint64_t window = promise_.k >= 64 ? ~0ull : (1ull << promise_.k) - 1;
    const bool holds = std::popcount(history_ & window) <= promise_.k - promise_.m;
    const bool breaks = !holds && holds_;
    broken_ += breaks ? 1u : 0u;
    holds_ = holds;
    return breaks;
  }
  /// Notes `count` missed releases; cost is bounded by the window. True as note().
  bool note_missed(std::uint64_t count) {
    const std::uint64_t one_by_one = count < 64 ? count : 64;
    // The releases before the last 64 have left every window by then.
    missed_ += count - one_by_one;
    in_row_ += count - one_by_one;
    bool breaks = false;
    for (std::uint64_t i = 0; i < one_by_one; ++i) breaks = note(false) || breaks;
    return breaks;
  }

  std::uint64_t missed() const { return missed_; }
  std::uint64_t in_row() const { return in_row_; }              ///< misses in a row up to now
  std::uint64_t worst_in_row() const { return worst_in_row_; }  ///< most misses in a row ever
  std::uint64_t broken() const { return broken_; }              ///< times that the promise was broken
  FirmPromise promise() const { return promise_; }

  /// State to bytes and back.
  void archive(Archive& archive) {
    Members(archive, *this, "miss window")
        .fixed(promise_)
        .state(history_, missed_, in_row_, worst_in_row_, broken_, holds_);
  }

 private:
  FirmPromise promise_{};
  std::uint64_t history_{};
  std::uint64_t missed_{};
  std::uint64_t in_row_{};
  std::uint64_t worst_in_row_{};
  std::uint64_t broken_{};
  bool holds_{true};
};

}  // namespace sortie::rt
