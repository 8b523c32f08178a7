// SPDX-License-Identifier: BSD-3-Clause
// Where the closed loop is measured: built worlds and recorded places, and ways through them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "hil/ray_caster.hpp"
#include "mapping/grid/sensor_pose.hpp"

namespace sortie::bench {

/// A place to look at, and the way of the sensor through it.
struct LoopWorld {
  std::unique_ptr<hil::World> built;
  std::vector<std::uint32_t> bits;
  std::unique_ptr<hil::VoxelWorld> recorded;
  std::vector<rt::Vector3> way;  ///< of the sensor, a polyline
  double start_m{};              ///< along it, at time 0
  double speed_m_s{1.0};
  double yaw_rad{};  ///< of the sensor at time 0
  double turn_rad_s{};

  hil::RayCaster caster() const { return built ? hil::RayCaster(*built) : hil::RayCaster(*recorded); }
  /// The sensor at a time; the way is walked to its end and back.
  mapping::SensorPose pose(double t_s) const;
};

/// A kind of world; `make` gives another one for each seed.
struct LoopScene {
  std::string name;
  LoopWorld (*make)(std::uint64_t seed);
};

/// The scenes that can be measured here; the names of those that cannot, with the cure, in `missing`.
std::vector<LoopScene> loop_scenes(std::vector<std::string>& missing);

}  // namespace sortie::bench
