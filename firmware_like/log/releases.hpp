// SPDX-License-Identifier: BSD-3-Clause
// Lateness and response of every group, counted again from jobs that were kept: by a log or a flight ring.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/wire_records.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/result/results.hpp"
#include "rt/histogram.hpp"
#include "rt/posix/flight_reader.hpp"
#include "rt/time.hpp"

namespace sortie::firmware {

/// The releases of one group, as its table says they are.
struct ReleaseRule {
  std::string name;
  rt::Nanoseconds base_tick_ns{};
  rt::Nanoseconds epoch_ns{};
  std::uint64_t period_ticks{1};
  std::uint64_t deadline_ticks{};
  bool from_start{};  ///< the jobs begin with the run, so that releases before the first job were left out
  std::uint64_t phase_ticks{};
};

/// Counts the jobs of one group in the order of their ticks. A release without a job counts as late until the
/// next job begins, as in the run itself.
class ReleaseCounter {
 public:
  explicit ReleaseCounter(ReleaseRule rule) : rule_(std::move(rule)), next_(rule_.phase_ticks) {}

  void job(rt::Tick tick, rt::Nanoseconds started_ns, rt::Nanoseconds ended_ns, bool missed);
  GroupResult result() const;
  /// Puts lateness and response alone into a result.
  void put_times(GroupResult& result) const { set_releases(lateness_, response_, result); }

 private:
  ReleaseRule rule_;
  rt::LatencyHistogram lateness_;
  rt::LatencyHistogram response_;
  std::uint64_t jobs_{};
  std::uint64_t missed_{};
  std::uint64_t skipped_{};
  rt::Tick next_;
};

/// One timing event of a log. False where it is damaged or says what no job can say.
bool read_timing(const StoredEvent& event, drivers::JobTimingRecord& timing);

/// From a log that was recorded live. Throws InputError when it holds no measured times, or those of a run in
/// simulated time, where nothing is late.
std::vector<GroupResult> releases_of(const LogFile& log);

/// From the jobs that a flight ring still holds.
std::vector<GroupResult> releases_of(const rt::posix::FlightReader& ring);

}  // namespace sortie::firmware
