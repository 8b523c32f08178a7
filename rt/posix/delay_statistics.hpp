// SPDX-License-Identifier: BSD-3-Clause
// Delays of one group of tasks, raw and explained, in fixed memory.
#pragma once

#include <cstdint>

#include "rt/histogram.hpp"
#include "rt/posix/delay_cause.hpp"

namespace sortie::rt::posix {

/// What was late.
enum class DelayKind : std::uint8_t {
  start,      ///< the job began after its release
  execution,  ///< the job took longer than its budget
};

/// One delay above the threshold.
struct DelayOutlier {
  Tick tick{};
  Nanoseconds at_ns{};  ///< when the job began (start) or ended (execution), CLOCK_MONOTONIC
  DelayKind kind{};
  Nanoseconds late_ns{};       ///< start: after the release; execution: beyond the budget
  DelaySplit split;            ///< adds up to late_ns
  std::uint32_t interrupts{};  ///< evidence: on its core at that time, beyond the usual
  Nanoseconds pause_ns{};      ///< evidence: of that time, all heartbeats were missing
};

/// All delays of one kind. Nothing is ever taken out of `raw`.
struct DelayTable {
  LatencyHistogram raw;          ///< start: lateness; execution: wall time of the job
  std::uint64_t clean_count{};   ///< of `raw`, without outliers whose main cause lies outside the program
  std::uint64_t clean_max_ns{};  ///< longest of those
  std::uint64_t outliers{};      ///< delays above the threshold that have been explained
  std::uint64_t count[kDelayCauses]{};   ///< of these, by main cause
  Nanoseconds total_ns[kDelayCauses]{};  ///< of these, time by cause

  /// Counts a delay that needs no explanation.
  void add_clean(std::uint64_t raw_ns) {
    ++clean_count;
    if (raw_ns > clean_max_ns) clean_max_ns = raw_ns;
  }

  /// Counts an outlier. `raw_ns`: what `raw` has recorded for it.
  void add_outlier(const DelaySplit& split, std::uint64_t raw_ns) {
    const DelayCause cause = split.main_cause();
    ++outliers;
    ++count[static_cast<int>(cause)];
    for (int i = 0; i < kDelayCauses; ++i) total_ns[i] += split.ns[i];
    if (cause == DelayCause::own || cause == DelayCause::unknown) add_clean(raw_ns);
  }
};

/// Delays of a group. About 36 kB.
struct DelayStatistics {
  static constexpr std::uint32_t kLast = 64;

  DelayTable start;
  DelayTable execution;
  DelayOutlier last[kLast];          ///< a ring: outlier i stands at i % kLast
  std::uint64_t outliers{};          ///< of both kinds, ever
  std::uint64_t without_evidence{};  ///< of these, decided before all witnesses had been heard
  std::uint64_t failed_readings{};   ///< the thread's account could not be read: such delays are unknown

  /// Counts an explained outlier of either kind.
  void add(const DelayOutlier& outlier, std::uint64_t raw_ns) {
    (outlier.kind == DelayKind::start ? start : execution).add_outlier(outlier.split, raw_ns);
    last[outliers++ % kLast] = outlier;
  }
};

}  // namespace sortie::rt::posix
