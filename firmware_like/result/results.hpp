// SPDX-License-Identifier: BSD-3-Clause
// What every command of `sortie` ends with: the answer, its errors, its timing and its memory, as one plain
// struct, one JSON object and one short table.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "firmware_like/result/finding.hpp"
#include "firmware_like/result/results_delays.hpp"
#include "firmware_like/result/results_schedule.hpp"
#include "rt/describe.hpp"
#include "rt/histogram.hpp"

namespace sortie::firmware {

class Json;

/// One bar of a latency histogram: `count` jobs took between `from_us` and `to_us`.
struct HistogramBar {
  double from_us{};
  double to_us{};
  std::uint64_t count{};
};

/// What a histogram counts in nanoseconds, bar by bar.
std::vector<HistogramBar> bars_of(const rt::LatencyHistogram& histogram);

/// Timing of one task over a run. Times are of the job's own execution, in microseconds, on the machine that
/// ran this command: in a replay not the robot's, which stand in Results::live.
struct TaskResult {
  std::string name;
  std::string group;
  double period_us{};
  double budget_us{};  ///< declared; 0 = none declared
  std::uint64_t count{};
  std::uint64_t missed{};
  double p50_us{};
  double p99_us{};
  double p999_us{};
  double max_us{};
  std::string digest;                   ///< hex, empty where the task has none
  std::vector<HistogramBar> histogram;  ///< optional, ascending, without gaps in meaning
  SORTIE_FIELDS(name, group, period_us, budget_us, count, missed, p50_us, p99_us, p999_us, max_us)
};

/// Releases of one group over a run. Lateness, response and all below them are those of the live run, from
/// itself or from its log (see LiveTimes); lateness and response count releases that were left out as late.
struct GroupResult {
  std::string name;
  double period_us{};
  double phase_us{};
  double deadline_us{};
  int core{-1};
  std::uint64_t jobs{};
  std::uint64_t missed{};
  std::uint64_t skipped{};
  std::uint64_t worst_in_row{};     ///< most releases in a row that were not met
  std::uint64_t promises_broken{};  ///< times that the (m,k) promise broke
  double late_p50_us{};             ///< begin of the job after its release
  double late_p99_us{};
  double late_p999_us{};
  double late_max_us{};
  double response_max_us{};            ///< end of the job after its release
  bool wake_known{};                   ///< the next three were measured
  double spinning{};                   ///< share of a core spent spinning before releases
  double margin_us{};                  ///< the spin margin at the end
  std::uint64_t stack_bytes{};         ///< most stack that the worker had in use
  GroupDelays delays;                  ///< why jobs were late
  std::vector<HistogramBar> lateness;  ///< empty: lateness and response are not known
  std::vector<HistogramBar> response;
  SORTIE_FIELDS(name, period_us, phase_us, deadline_us, core, jobs, missed, skipped, worst_in_row,
                promises_broken)  // what is known in any case
};

/// Puts what was counted of a group's releases, in nanoseconds, into its result.
void set_releases(const rt::LatencyHistogram& lateness, const rt::LatencyHistogram& response,
                  GroupResult& group);

/// How long the jobs of one task took on the robot, in microseconds.
struct LiveTask {
  std::string name;
  std::uint64_t count{};
  double p50_us{};
  double p99_us{};
  double p999_us{};
  double max_us{};
  SORTIE_FIELDS(name, count, p50_us, p99_us, p999_us, max_us)
};

/// The times of the live run that a result is about. The rule for whoever adds a figure: what a clock gave
/// stands here, or in the live part of a group (late_*, response_*, spinning, margin, stack, delays), only if
/// it was taken during the live run. A live run fills it itself, a replay from the log and never from its own
/// clock; the times of a replay itself stand in Results::tasks and Results::speed. What is not known is said
/// with its cure and is no zero.
struct LiveTimes {
  bool known{};
  std::string why_not;        ///< if not known: why, and what to do
  std::string why_no_causes;  ///< if wake-ups and causes are not known, though the rest is: the same
  std::vector<LiveTask> tasks;
  std::uint64_t over_budget{};  ///< jobs of tasks that took longer than declared
};

/// Fill level of one memory pool over a run.
struct PoolResult {
  std::string name;
  std::uint64_t capacity{};
  std::uint64_t high_water{};
  std::uint64_t refused{};
  std::uint64_t bytes{};
  SORTIE_FIELDS(name, capacity, high_water, refused, bytes)
};

/// Result of a run, a replay or a check. Set-up side only: it owns heap memory.
struct Results {
  std::string digest;  ///< of all task outputs of all ticks, hex
  std::uint64_t ticks{};
  std::string scene;
  std::string vehicle;
  std::map<std::string, double> errors;  ///< unit is the suffix of the key: ate_rmse_m, heading_rmse_deg
  std::vector<TaskResult> tasks;
  std::vector<GroupResult> groups;
  ScheduleResult schedule;
  std::vector<ChainResult> chains;
  std::vector<PoolResult> pools;
  std::map<std::string, std::uint64_t> counters;
  double duration_s{};  ///< span of the log or run
  double speed{};       ///< span divided by wall time; 0 = not measured
  LiveTimes live;       ///< what was measured where the robot drove
  std::string machine;
  std::string compiler;
  std::string profile_hash;           ///< of the profile with its overrides, hex
  std::vector<std::string> left_out;  ///< what the vehicle could have and the scene does without: tasks, and
                                      ///< what tells the outside
  std::vector<std::string> warnings;
  DoctorReport doctor;  ///< of the machine whose times these are; not present: nobody looked
};

/// Adds the counters of a part to those of a result, each as `prefix` and its name.
template <rt::Described Counters>
void add_counters(const std::string& prefix, const Counters& counters,
                  std::map<std::string, std::uint64_t>& out) {
  rt::for_each_scalar(counters, [&](const char* name, int, auto count) { out[prefix + name] = count; });
}

/// The interface object of `--json`. Key names are fixed: digest, ticks, scene, errors{}, tasks[]{name,
/// period_us, budget_us, count, missed, p50_us, p99_us, p999_us, max_us}, pools[]{name, capacity, high_water,
/// refused}, counters{}; more keys may follow them. A figure that is not finite becomes null.
Json to_json(const Results& results);

/// The short table that ends a run: at most about 25 lines and 100 columns. Colour (misses, refusals,
/// warnings) only if `colour`, which the caller sets when the stream is a terminal and NO_COLOR is unset.
void print_table(std::ostream& out, const Results& results, bool colour = false);

/// How a command shows its result: the table, or one JSON object, on stdout. `judged`: what made the command
/// fail, where something judged it; JSON then has `passed` and `failures`.
void print_results(const Results& results, bool json, const std::vector<std::string>* judged);

/// Prints a line for each reason why the command ends with 1; beside JSON on stderr.
void print_failures(const std::vector<std::string>& failures, bool json);

/// True when `fd` is a terminal and NO_COLOR is unset or empty.
bool wants_colour(int fd);

/// "AMD EPYC 7B13, 2 cores, Linux 6.1.0 x86_64": what the figures were measured on. Reads /proc/cpuinfo and
/// uname.
std::string machine_description();

/// "g++ 12.2.0, optimised, x86-64": what built this program.
std::string compiler_description();

}  // namespace sortie::firmware
