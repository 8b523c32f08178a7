// SPDX-License-Identifier: BSD-3-Clause
// What a sweep is going to run: every cell laid out and built once, before the first one runs.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// The cells of one sweep of a log: values and marks are filled in, figures are not.
struct SweepPlan {
  Sweep sweep;
  std::vector<std::vector<std::string>> overrides;  ///< key=value each, one list a cell
  std::vector<std::uint64_t> profiles;              ///< Profile::hash() of each cell
};

/// The sweeps that `options` ask of a log: the grid, or one for each knob of its scene's algorithms. Throws
/// ProfileError where the scene has none.
std::vector<SweepOptions> sweeps_of(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                                    const SweepOptions& options);

/// The values that are tried of a declared key: a number at a quarter, half, twice and four times what it is,
/// within its range; of a choice all. Less than two: there is nothing to try.
std::vector<std::string> knob_values(const firmware::ProfileKey& key);

/// Builds a scene with these overrides. Throws ProfileError.
using SceneBuilder =
    std::function<std::unique_ptr<firmware::Runtime>(const std::vector<std::string>& overrides)>;

/// A sweep for each knob that the scene reads, as `all` says but for its knobs. Knobs are the keys that their
/// structs mark as such (rt::kKnob): numbers and choices that trade error for run time or memory, and that a
/// replay can judge. What acts on the robot (drive, flippers, rays, flight) is none: a log does not hold what
/// would have happened; `bench rays`, `bench uav` and `scenes --cost` drive anew. A value with which the
/// scene cannot be built is left out: a rate that does not fit the tick, a part of a whole number. So is the
/// map where the knob is not the map's, so that a replay takes no longer than it must; a knob of the map is
/// judged by it. Throws ProfileError where there is no knob.
std::vector<SweepOptions> each_knob_alone(const SceneBuilder& build, const SweepOptions& all);

/// Lays out the cells of a sweep: the grid, then the profile's own choice where the grid does not hold it.
/// Builds the runtime of every cell, so that a bad value shows at once. Throws ProfileError (unknown key with
/// the nearest known ones, value out of range, unknown task).
SweepPlan plan_sweep(const firmware::LogFile& log, const firmware::VehicleRegistry& vehicles,
                     const SweepOptions& options);

/// What messages call a cell: its overrides, or that there are none.
std::string cell_title(const std::vector<std::string>& overrides);

}  // namespace sortie::toolchain
