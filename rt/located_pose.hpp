// SPDX-License-Identifier: BSD-3-Clause
// Where a robot is on a map that it makes, as it crosses rooms: output of the task, message, trajectory.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// The place of one scan. Frames: map, fixed to what the scans saw; odom, the odometry's world; sensor; body.
/// Quaternions are w, x, y, z.
struct LocatedPose {
  static constexpr std::uint8_t kFirst = 1;  ///< verdict: the map begins with this scan
  static constexpr std::uint8_t kAccepted = 2;
  static constexpr std::uint8_t kNewPlace = 9;   ///< hardly on the map yet: placed by the odometry
  static constexpr std::uint8_t kUnplaced = 10;  ///< where the robot is on a kept map is not known

  Nanoseconds stamp_ns{};    ///< of the scan, on the odometry's clock; 0: none yet
  std::uint8_t verdict{};    ///< mapping::LocateVerdict: one that is not placed says why
  double p_map_odom_m[3]{};  ///< T_map_odom of the newest accepted scan
  double q_map_odom[4]{1, 0, 0, 0};
  double p_map_body_m[3]{};  ///< T_map_body of this scan; of one that was refused, where the odometry says,
                             ///< and without odometry where the scan before was
  double q_map_body[4]{1, 0, 0, 0};
  double p_map_sensor_m[3]{};  ///< the same of the sensor
  double q_map_sensor[4]{1, 0, 0, 0};
  double covariance[36]{};  ///< of T_map_sensor: (position in map, rotation in sensor), row-major, m^2, rad^2
  double share{};           ///< of the matched returns, on the map's surfaces
  double known{};           ///< of them, in cells that have a surface
  double crossed{};         ///< of the rays, through surfaces
  std::uint32_t returns{};  ///< that were matched
  std::uint32_t steps{};    ///< of work
  std::uint32_t weak_moves{};  ///< directions that the scan does not hold, at most 3: so many of the arrays
  std::uint32_t weak_turns{};
  double weak_move_map[9]{};  ///< unit vectors, one behind the other
  double weak_move_sigma_m[3]{};
  double weak_turn_map[9]{};  ///< axes
  double weak_turn_sigma_rad[3]{};
  std::uint64_t scans{};   ///< so far
  std::uint64_t placed{};  ///< of them: first, accepted or new place
  SORTIE_FIELDS(stamp_ns, verdict, p_map_odom_m, q_map_odom, p_map_body_m, q_map_body, p_map_sensor_m,
                q_map_sensor, covariance, share, known, crossed, returns, steps, weak_moves, weak_turns,
                weak_move_map, weak_move_sigma_m, weak_turn_map, weak_turn_sigma_rad, scans, placed)

  /// The scan is part of the map.
  constexpr bool is_placed() const {
    return verdict == kFirst || verdict == kAccepted || verdict == kNewPlace;
  }
};

}  // namespace sortie::rt
