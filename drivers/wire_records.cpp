// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/wire_records.hpp"

namespace sortie::drivers {

PoseMessage to_pose_message(const rt::PoseEstimate& estimate, std::int64_t utime) noexcept {
  PoseMessage pose;
  pose.utime = utime;
  const double* q = estimate.q_world_body;
  const double* v = estimate.v_body_m_s;
  // v + 2 w (u x v) + 2 u x (u x v), with u the vector part of q.
  const double t[3] = {2 * (q[2] * v[2] - q[3] * v[1]), 2 * (q[3] * v[0] - q[1] * v[2]),
                       2 * (q[1] * v[1] - q[2] * v[0])};
  pose.vel[0] = v[0] + q[0] * t[0] + (q[2] * t[2] - q[3] * t[1]);
  pose.vel[1] = v[1] + q[0] * t[1] + (q[3] * t[0] - q[1] * t[2]);
  pose.vel[2] = v[2] + q[0] * t[2] + (q[1] * t[1] - q[2] * t[0]);
  for (int i = 0; i < 3; ++i) pose.pos[i] = estimate.p_world_body_m[i];
  for (int i = 0; i < 4; ++i) pose.orientation[i] = q[i];
  for (int i = 0; i < 3; ++i) pose.rotation_rate[i] = estimate.w_body_rad_s[i];
  return pose;
}

}  // namespace sortie::drivers
