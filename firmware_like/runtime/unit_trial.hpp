// SPDX-License-Identifier: BSD-3-Clause
// What a work unit of an anytime task takes on this machine, tried at the boot of a live run. It warns; what
// tasks do does not depend on it, but where a scene says units = "auto".
#pragma once

#include <cstdint>
#include <string>

namespace sortie::mapping {
struct OccupancyConfig;
}  // namespace sortie::mapping
namespace sortie::planner {
struct SslChoiceConfig;
}  // namespace sortie::planner

namespace sortie::firmware {

/// A trial's outcome.
struct UnitTrial {
  std::string task;       ///< empty: nothing was tried
  double ns_per_unit{};   ///< of the dearest map that was tried
  std::uint32_t units{};  ///< what the task may spend
  double budget_us{};     ///< what it may take
  explicit operator bool() const { return !task.empty(); }
};

/// Plans over a map that is wholly unknown and over one of scattered walls, and times both; of three times
/// the shortest counts, so that what else the machine does is not taken for its speed. Takes memory of its
/// own for as long as it runs (as much as the task's), and about 30 ms.
UnitTrial try_ray_units(const planner::SslChoiceConfig& choice, const mapping::OccupancyConfig& map);

/// Share of its budget that a task with units = "auto" plans with: the rest is for what its units do not
/// count (rays that come in, poses), and for maps that are dearer than those tried.
inline constexpr double kAutoShare = 0.8;

/// The units that take `share` of the budget, from 1 to 4e9; the trial must have timed something.
std::uint32_t units_that_fit(const UnitTrial& trial, double share);

/// What to tell a user when the units do not fit into the budget, with those that would; or empty.
std::string unit_warning(const UnitTrial& trial);

}  // namespace sortie::firmware
