// SPDX-License-Identifier: BSD-3-Clause
// The times of a live run, from its log: what the robot's clock said, for whoever replays it elsewhere.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/releases.hpp"
#include "firmware_like/runtime/chain_meter.hpp"
#include "firmware_like/runtime/input_port.hpp"
#include "firmware_like/runtime/runtime.hpp"

namespace sortie::firmware {

/// Which counters of a live run no replay can count again: its log keeps them.
inline constexpr const char* kLiveCounters[] = {"events", "heap_calls", "ladder_worst_level", "stuck_jobs"};

/// Writes what only the end of a live run knows into its log: wake-ups and causes of each group, and
/// kLiveCounters of `results`. One event of kind `measured` a group and one for the run. `log` takes it as it
/// takes samples. Off the real-time path; takes heap.
void write_measured(SampleSink& log, const Results& results, rt::Nanoseconds run_time_ns,
                    rt::Nanoseconds utc_minus_run_ns);

/// Follows the jobs of a replay through the times that the log holds for them. One thread at a time. Cost: a
/// decoded event a job; memory 8 bytes an event and a histogram a task.
class RecordedTimes {
 public:
  /// `why_not`: empty, or why this log's times are not those of a live run of this runtime; then nothing is
  /// known. `whole`: all jobs from the first tick to the last are asked for.
  RecordedTimes(const LogFile& log, const Runtime& runtime, std::string why_not, bool whole);

  /// The times of that job, or null. Jobs of a group come in order. Valid until the group's next.
  const JobTimes* find(const rt::JobRecord& record);
  /// Counts a job of the part that was asked for. `times`: what find() gave.
  void count(const rt::JobRecord& record, const JobTimes* times);
  /// Puts the live run's times, wake-ups, causes and counters into the results of a replay.
  void add_to(Results& results) const;

 private:
  struct GroupTimes {
    std::vector<const StoredEvent*> events;
    std::size_t next{};
    JobTimes current;
    std::vector<rt::LatencyHistogram> tasks;
    std::uint64_t jobs{};
    std::uint64_t without{};  // jobs whose times the log does not hold
    bool without_is_last{};   // the newest job is such a one
  };

  void add_measured(Results& results) const;

  const LogFile& log_;
  const Runtime& runtime_;
  std::string why_not_;
  bool whole_;
  std::vector<GroupTimes> groups_;
  std::vector<ReleaseCounter> releases_;
  std::uint64_t over_budget_{};
};

/// Empty, or why the log holds no times of a live run, and the cure.
std::string why_no_times(const LogFile& log);

}  // namespace sortie::firmware
