// SPDX-License-Identifier: BSD-3-Clause
// Obstacle scenes for the odometry: families of shapes whose sizes follow from a seed.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "hil/plant/plant_scene.hpp"
#include "hil/plant/vehicle_model.hpp"

namespace sortie::bench {

/// One drive over one obstacle.
struct CourseScene {
  std::string family;  ///< what kind of obstacle
  std::string name;    ///< with its sizes
  std::function<void(hil::PlantScene&)> build;
  hil::Vec3 start_m{0.0, 0.0, 0.07192};
  hil::Quat start_q_world_body;
  double way_m{3.0};        ///< of belt travel, forward; negative: backwards
  double turn_rad_per_m{};  ///< of what the belts ask for
  double friction{0.9};
  double flipper_rad[hil::kFlippers]{};
  bool planar{};  ///< only flats and slopes: nothing to climb over
};

/// All families once with the flippers folded and once in use, with sizes of this seed. Same seed, same
/// scenes.
std::vector<CourseScene> course_scenes(std::uint64_t seed);

}  // namespace sortie::bench
