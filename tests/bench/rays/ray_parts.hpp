// SPDX-License-Identifier: BSD-3-Clause
// The parts of the ray scheduler's benchmark.
#pragma once

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// How much is measured.
struct RaySettings {
  int rounds{3};  ///< of what is timed
  int seeds{2};   ///< streets
};

/// Worth against run time, ours beside the published planners.
void measure_ray_curves(const RaySettings& settings, Report& report);
/// The nine hard maps: time of a unit, units of a budget.
void measure_ray_units(const RaySettings& settings, Report& report);
/// Chosen rays over the entropy of the map.
void measure_ray_picture(const RaySettings& settings, Report& report);

}  // namespace sortie::bench
