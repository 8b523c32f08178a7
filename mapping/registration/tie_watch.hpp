// SPDX-License-Identifier: BSD-3-Clause
// Odometry that began anew, or jumped: scan after scan is matched far from where it says, and all of them say
// the same of where it hangs on the map.
#pragma once

#include <algorithm>
#include <cstdint>

#include "mapping/registration/pose_algebra.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// Scans that agree on another T_map_odom, until one is accepted. A place that looks like another one, or a
/// robot that seems to stand still, does not go on agreeing with the odometry's way.
class TieWatch {
 public:
  void clear() { scans_ = 0; }
  /// A scan was matched where the odometry does not have it. True: with those before it is enough.
  bool agrees(const RigidPose& T_map_sensor, const RigidPose& T_odom_sensor) {
    if (scans_ == 0 || are_apart(after(T_map_odom_, T_odom_sensor), T_map_sensor, kNear_m, kNear_rad)) {
      T_map_odom_ = after(T_map_sensor, inverse(T_odom_sensor));
      from_m_ = T_odom_sensor.p;
      way_m_ = 0.0;
      scans_ = 1;
      return false;
    }
    scans_ = std::min(scans_ + 1, kScans);
    way_m_ = std::max(way_m_, rt::norm(T_odom_sensor.p - from_m_));
    return scans_ == kScans && way_m_ >= kWay_m;
  }
  const RigidPose& T_map_odom() const { return T_map_odom_; }

  SORTIE_FIELDS(T_map_odom_, from_m_, way_m_, scans_)

 private:
  static constexpr std::uint32_t kScans = 5;
  static constexpr double kWay_m = 0.5;
  static constexpr double kNear_m = 0.1;
  static constexpr double kNear_rad = 0.0174533;

  RigidPose T_map_odom_;  ///< of the first of them
  rt::Vector3 from_m_;    ///< the odometry's place at the first of them
  double way_m_{};        ///< the farthest from there
  std::uint32_t scans_{};
};

}  // namespace sortie::mapping
