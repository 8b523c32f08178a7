// SPDX-License-Identifier: BSD-3-Clause
// A course: obstacles in a row of a table, built once for the plant's contacts and once for the rays.
#pragma once

#include <cstdint>
#include <vector>

#include "hil/plant/obstacles.hpp"
#include "hil/world.hpp"

namespace sortie::hil {

/// What stands somewhere.
enum class CourseKind : std::uint8_t { stairs, pallet, ramp, rubble, cylinder, wall };

/// One obstacle, from (x, y) along its heading. Sizes that its kind does not have are not looked at.
struct CoursePiece {
  CourseKind kind{};
  double x_m{};
  double y_m{};
  double yaw_rad{};
  double length_m{1.0};    ///< ramp: of the slope; rubble: of the field; wall: ahead; stairs: of the landing
  double width_m{1.2};     ///< across; of a cylinder its length
  double height_m{0.1};    ///< cylinder: radius; wall: height; stairs: rise of a step
  double slope_rad{0.3};   ///< ramp
  double deck_m{1.0};      ///< ramp: of the level part behind it
  double run_m{0.28};      ///< stairs: of a step
  std::uint32_t count{5};  ///< stairs: steps; rubble: blocks
};

/// A table of them on the plane z = 0.
struct CourseConfig {
  std::uint64_t seed{1};  ///< of the rubble; a report must print it
  std::vector<CoursePiece> pieces;
};

/// Adds every solid of the scene to a world, which finalize() must follow: the same solids to the last digit.
/// Half-spaces are left to the caller: a world has its ground at z = 0 and no other. Status: ok; that of
/// World::add(), not_supported for neither box nor cylinder; solids added before a refusal stay.
Status add_to_world(const PlantScene& scene, World& world);

/// Builds scene and world, the world finalized. Both must be empty. Set-up code: throws std::runtime_error
/// with the row of the piece that does not fit, and why.
void build_course(const CourseConfig& config, PlantScene& scene, World& world);

}  // namespace sortie::hil
