// SPDX-License-Identifier: BSD-3-Clause
// What is true about a simulated body: the state that sensors look at and results are judged by.
#pragma once

#include "hil/geometry.hpp"
#include "rt/samples.hpp"

namespace sortie::hil {

/// Exact state of a simulated body at one instant. World: z up. Body: x forward, y left, z up; its origin
/// lies on the ground between the tracks.
struct Motion {
  rt::Nanoseconds stamp_ns{};
  Vec3 p_world_body_m;
  Quat q_world_body;
  Vec3 v_world_m_s;   ///< velocity of the body's origin
  Vec3 w_body_rad_s;  ///< turn rate
  double left_m{};    ///< travel of the left belt since start, as its encoder would see it
  double right_m{};   ///< the same of the right belt
};

/// The state between two near instants: position straight, attitude on the shortest way. `share` in [0, 1].
inline void pose_between(const Motion& before, const Motion& after, double share, Vec3& p_world_m,
                         Quat& q_world) {
  p_world_m = before.p_world_body_m + share * (after.p_world_body_m - before.p_world_body_m);
  q_world = blend(before.q_world_body, after.q_world_body, share);
}

/// The state as a reference for results.
inline rt::TruthSample to_truth(const Motion& motion) {
  rt::TruthSample truth;
  truth.stamp_ns = motion.stamp_ns;
  store(motion.p_world_body_m, truth.p_world_body_m);
  truth.q_world_body[0] = motion.q_world_body.w;
  truth.q_world_body[1] = motion.q_world_body.x;
  truth.q_world_body[2] = motion.q_world_body.y;
  truth.q_world_body[3] = motion.q_world_body.z;
  truth.flags = rt::kTruthPosition | rt::kTruthHeight | rt::kTruthOrientation;
  return truth;
}

}  // namespace sortie::hil
