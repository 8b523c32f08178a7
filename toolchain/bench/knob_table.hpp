// SPDX-License-Identifier: BSD-3-Clause
// Which keys of a profile are knobs of an algorithm: numbers and choices that trade error for run time or
// memory, and that a replay can judge. Name, unit, range, default and meaning stand where each key is read.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"
#include "toolchain/sweep/knob.hpp"

namespace sortie::toolchain {

/// One knob. What acts on the robot (drive, flippers, rays, flight) is none of these: a log does not hold
/// what would have happened; `bench rays`, `bench uav` and `scenes --cost` drive anew.
struct Knob {
  const char* part;  ///< the algorithm, by its name in scene_parts(); "state" and "pose" of a flying robot
  const char* key;
};

/// All of them, by part.
std::span<const Knob> algorithm_knobs();

/// A knob of one scene and what it is going to be tried at.
struct KnobTrial {
  Knob knob{};
  firmware::ProfileKey declared;   ///< unit, range, value and meaning in that scene
  std::vector<std::string> tried;  ///< the scene's own value among them, in ascending order of numbers
};

/// The values that are tried of a declared key: a number at a quarter, half, twice and four times what it is,
/// within its range; of a choice all. Less than two: there is nothing to try.
std::vector<std::string> knob_values(const firmware::ProfileKey& key);

/// The knobs that a scene reads. A value with which the scene cannot be built is left out: a rate that does
/// not fit the tick, a part of a whole number. `overrides` are of every trial.
std::vector<KnobTrial> knob_trials(const std::string& scene, const std::vector<std::string>& overrides,
                                   const firmware::VehicleRegistry& vehicles);

/// What a sweep of that knob does without, so that a replay takes no longer than it must: the map where the
/// knob is not the map's.
std::vector<std::string> knob_overrides(const Knob& knob, const firmware::Profile& profile);

}  // namespace sortie::toolchain
