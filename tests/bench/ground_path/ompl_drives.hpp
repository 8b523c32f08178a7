// SPDX-License-Identifier: BSD-3-Clause
// OMPL's planners on the same hall, with the same prices.
#pragma once

#include <string>

#include "tests/bench/ground_path/ground_course.hpp"

namespace sortie::bench {

/// Why it is not there, and the cure; empty where it is.
std::string ompl_drives_missing();
/// What it was told, in words.
std::string ompl_drives_settings();
void seed_ompl_drives(std::uint32_t seed);

/// Optimal planners that were asked.
enum class OmplPlanner : std::uint8_t { rrt_star, bit_star };

/// What a planner found within so many seconds of processor time, each time it was cheaper.
std::vector<CourseStep> run_ompl(OmplPlanner which, planner::test::OwnedGround& ground,
                                 const planner::GroundPose& start, const planner::GroundPose& goal,
                                 double seconds);

}  // namespace sortie::bench
