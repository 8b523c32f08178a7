// SPDX-License-Identifier: BSD-3-Clause
// Poses one after the other, and back.
#pragma once

#include "mapping/grid/rolling_grid_config.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// T_a_c of T_a_b and T_b_c. The rotation is normalised.
inline RigidPose after(const RigidPose& a, const RigidPose& b) {
  return {a.p + rt::rotate(a.q, b.p), rt::normalised(a.q * b.q)};
}

/// T_b_a of T_a_b.
inline RigidPose inverse(const RigidPose& a) {
  return {-1.0 * rt::rotate_back(a.q, a.p), rt::conjugate(a.q)};
}

/// Farther from each other than that, m or rad.
inline bool are_apart(const RigidPose& a, const RigidPose& b, double move_m, double turn_rad) {
  return rt::norm(a.p - b.p) > move_m || rt::norm(rt::log_rotation(a.q * rt::conjugate(b.q))) > turn_rad;
}

}  // namespace sortie::mapping
