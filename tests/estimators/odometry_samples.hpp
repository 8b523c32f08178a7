// SPDX-License-Identifier: BSD-3-Clause
// Attitudes for the track odometry, and what it says.
#pragma once

#include "estimators/track_odometry.hpp"
#include "tests/estimators/units.hpp"

namespace sortie::estimators::test {

using rt::Quaternion;
using rt::Vector3;

/// An attitude that is known, q_world_body, with its rate in the body in rad/s.
inline rt::AttitudeEstimate attitude_at(rt::Nanoseconds stamp, const Quaternion& q, const Vector3& w) {
  rt::AttitudeEstimate attitude;
  attitude.stamp_ns = stamp;
  rt::store(q, attitude.q_world_body);
  rt::store(w, attitude.w_body_rad_s);
  attitude.flags = 1;
  return attitude;
}
/// Where the odometry says the body is, world, m.
inline Vector3 position_of(const TrackOdometry& odometry) {
  return rt::to_vector(odometry.estimate().p_world_body_m);
}
/// One element of the diagonal of the covariance.
inline double variance(const TrackOdometry& odometry, int i) { return odometry.estimate().covariance[7 * i]; }

}  // namespace sortie::estimators::test
