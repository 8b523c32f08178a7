// SPDX-License-Identifier: BSD-3-Clause
// Whose times are whose: what was measured where the robot drove, apart from what the machine measures that
// replays its log.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "rt/describe.hpp"

namespace sortie::firmware {

class Json;

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

Json to_json(const LiveTimes& live);

}  // namespace sortie::firmware
