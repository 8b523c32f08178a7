// SPDX-License-Identifier: BSD-3-Clause
// Where one map of planes lies in another, with what was known of it before and after.
#pragma once

#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// A vector's mirror image about the plane through the origin that is square to `axis` (unit).
constexpr rt::Vector3 mirrored(const rt::Vector3& v, const rt::Vector3& axis) {
  return v - (2.0 * rt::dot(axis, v)) * axis;
}

/// x_target = scale * R(q_target_source) * x_source + p_target_source_m.
struct PlanePose {
  rt::Quaternion q_target_source;
  rt::Vector3 p_target_source_m;
  double scale{1};
  SORTIE_FIELDS(q_target_source, p_target_source_m, scale)
};

/// A point of the source's frame in the target's.
constexpr rt::Vector3 transform(const PlanePose& pose, const rt::Vector3& x_source_m) {
  return pose.scale * rt::rotate(pose.q_target_source, x_source_m) + pose.p_target_source_m;
}

/// The other way round.
inline PlanePose inverse(const PlanePose& pose) {
  PlanePose back;
  back.q_target_source = rt::conjugate(pose.q_target_source);
  back.scale = 1.0 / pose.scale;
  back.p_target_source_m = -back.scale * rt::rotate(back.q_target_source, pose.p_target_source_m);
  return back;
}

/// A pose after a small turn and growth about a place of the target, which is shifted itself: `by` is (turn
/// rad, shift m, ln scale), as in PlaneFit.
inline PlanePose changed(const PlanePose& pose, const rt::Vector3& pivot_m, const double (&by)[7]) {
  const rt::Quaternion turn = rt::exp_rotation({by[0], by[1], by[2]});
  const double grown = rt::exp(by[6]);
  const rt::Vector3 turned = grown * rt::rotate(turn, pose.p_target_source_m - pivot_m);
  return {rt::normalised(turn * pose.q_target_source), pivot_m + rt::Vector3{by[3], by[4], by[5]} + turned,
          pose.scale * grown};
}

/// Whether two poses put a place of the source, `x_source_m`, that near to each other.
inline bool same_place(const PlanePose& a, const PlanePose& b, const rt::Vector3& x_source_m, double most_m,
                       double most_rad) {
  const rt::Vector3 apart = transform(a, x_source_m) - transform(b, x_source_m);
  const rt::Vector3 turn = rt::log_rotation(a.q_target_source * rt::conjugate(b.q_target_source));
  return rt::norm(apart) <= most_m && rt::norm(turn) <= most_rad;
}

/// What is known from outside: GPS, odometry, an earlier match. What the planes cannot say keeps its values.
struct PlaneEstimate {
  PlanePose T_target_source;
  double sigma_position_m{};      ///< of the middle of the source's planes, each axis; 0: nothing is known
  double sigma_yaw_rad{};         ///< about the target's z; 0: nothing is known
  double sigma_tilt_rad{0.0087};  ///< of the source's vertical in the target: gravity; 0: nothing is known
  double sigma_scale{};           ///< relative; 0: the scale is 1 and is not looked for
  SORTIE_FIELDS(T_target_source, sigma_position_m, sigma_yaw_rad, sigma_tilt_rad, sigma_scale)

  bool has_position() const { return sigma_position_m > 0.0; }
  bool has_yaw() const { return sigma_yaw_rad > 0.0; }
  bool has_gravity() const { return sigma_tilt_rad > 0.0; }
  bool wants_scale() const { return sigma_scale > 0.0; }
};

}  // namespace sortie::mapping
