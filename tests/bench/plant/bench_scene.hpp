// SPDX-License-Identifier: BSD-3-Clause
// The nine scenes that the plant and its peer drive: obstacles, start, command over time, closed form.
#pragma once

#include <vector>

#include "hil/plant/plant_scene.hpp"
#include "hil/plant/vehicle_config.hpp"

namespace sortie::bench {

/// Where the vehicle's origin is, and how it is turned.
struct BenchPose {
  hil::Vec3 p_world_m;
  hil::Quat q_world_body;
};

/// A span of driving: from rest to a speed, held, and from `end_s` on back to rest.
struct Pulse {
  double forward_m_s{};
  double turn_rad_s{};
  double begin_s{};
  double end_s{1e9};
};

/// What the paper on contact surface motion prints for its own scenes; negative: nothing.
struct Published {
  const char* figure{""};  ///< which sum, and of what
  double d_t{-1};
  double d_w{-1};
};

/// One scene.
struct BenchScene {
  const char* name{""};
  const char* about{""};
  double seconds{10};  ///< that are measured
  double settle_s{0};  ///< at rest before them, for flippers to sag
  double friction{0.7};
  void (*build)(hil::PlantScene& scene){};
  BenchPose start;
  double flipper_rad[4]{0.5, 0.5, 0.5, 0.5};
  std::vector<Pulse> pulses;
  bool closed_form{};  ///< the pose is known at every moment
  Published published;
};

/// The eight published scenes and stairs up, in the order of the table.
const std::vector<BenchScene>& bench_scenes();

}  // namespace sortie::bench
