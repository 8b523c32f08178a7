// SPDX-License-Identifier: BSD-3-Clause
// Each knob of a scene's algorithms alone. Knobs are the keys that their structs mark as such (rt::kKnob):
// numbers and choices that trade error for run time or memory, and that a replay can judge. What acts on the
// robot (drive, flippers, rays, flight) is none: a log does not hold what would have happened; `bench rays`,
// `bench uav` and `scenes --cost` drive anew.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "toolchain/sweep/sweep.hpp"

namespace sortie::toolchain {

/// The values that are tried of a declared key: a number at a quarter, half, twice and four times what it is,
/// within its range; of a choice all. Less than two: there is nothing to try.
std::vector<std::string> knob_values(const firmware::ProfileKey& key);

/// Builds a scene with these overrides. Throws ProfileError.
using SceneBuilder =
    std::function<std::unique_ptr<firmware::Runtime>(const std::vector<std::string>& overrides)>;

/// A sweep for each knob that the scene reads, as `all` says but for its knobs. A value with which the scene
/// cannot be built is left out: a rate that does not fit the tick, a part of a whole number. So is the map
/// where the knob is not the map's, so that a replay takes no longer than it must; a knob of the map is
/// judged by it. Throws ProfileError where there is no knob.
std::vector<SweepOptions> each_knob_alone(const SceneBuilder& build, const SweepOptions& all);

}  // namespace sortie::toolchain
