// SPDX-License-Identifier: BSD-3-Clause
// Where a sensor of a ground robot will be in a moment, from where the robot is and how it moves.
#pragma once

#include <cmath>

#include "mapping/grid/sensor_pose.hpp"
#include "rt/math.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"

namespace sortie::planner {

/// The body `ahead_s` after `pose`, on a level arc: the speed and the turn about the vertical stay, roll and
/// pitch stay as they are. Turning flatly is what tracks do on purpose; a rolling or pitching rate belongs to
/// an obstacle and is over soon. Exact for such a motion. Cost: two sincos.
inline mapping::SensorPose body_ahead(const rt::PoseEstimate& pose, double ahead_s) {
  const rt::Quaternion q = rt::to_quaternion(pose.q_world_body);
  const rt::Vector3 v = rt::rotate(q, rt::to_vector(pose.v_body_m_s));
  const double turn_rad = rt::rotate(q, rt::to_vector(pose.w_body_rad_s)).z * ahead_s;
  // The chord of the arc: turned by half the turn, and shorter by sin(x) / x of it.
  const double half = 0.5 * turn_rad;
  const rt::SinCos chord = rt::sincos(half);
  const double shorter = std::fabs(half) > 1e-4 ? chord.sin / half : 1.0 - half * half / 6.0;
  const rt::Vector3 way{ahead_s * shorter * (chord.cos * v.x - chord.sin * v.y),
                        ahead_s * shorter * (chord.sin * v.x + chord.cos * v.y), ahead_s * v.z};
  return {rt::to_vector(pose.p_world_body_m) + way, rt::exp_rotation({0, 0, turn_rad}) * q};
}

/// T_world_sensor from T_world_body and T_body_sensor.
inline mapping::SensorPose mounted(const mapping::SensorPose& body, const rt::Vector3& p_body_sensor_m,
                                   const rt::Quaternion& q_body_sensor) {
  return {body.p_world_sensor_m + rt::rotate(body.q_world_sensor, p_body_sensor_m),
          body.q_world_sensor * q_body_sensor};
}

}  // namespace sortie::planner
