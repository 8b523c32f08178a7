// SPDX-License-Identifier: BSD-3-Clause
// The solids of each family of courses, from the sizes that were drawn.
#pragma once

#include "hil/plant/course_families.hpp"
#include "hil/random.hpp"

namespace sortie::hil {

/// Where the first edge of every course lies, beyond a start at x = 0: the flippers reach to 0.61 m.
inline constexpr double kCourseLead_m = 1.0;
/// From the last edge to the goal: so far that the flippers behind have left it.
inline constexpr double kCourseTail_m = 1.1;

/// Adds the solids of `course`, whose sizes are drawn, to an empty scene, and sets start, goal, width and
/// first edge. `random` draws what has no size of its own: places of blocks and, for judging, all that is
/// uneven. Throws std::runtime_error where the scene is full.
void build_shape(Course& course, Random& random, PlantScene& scene);

}  // namespace sortie::hil
