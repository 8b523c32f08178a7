// SPDX-License-Identifier: BSD-3-Clause
// Samples for the attitude filter, and how far two attitudes are apart.
#pragma once

#include <cmath>

#include "estimators/attitude.hpp"
#include "tests/estimators/units.hpp"

namespace sortie::estimators::test {

using rt::Quaternion;
using rt::Vector3;

/// q_world_body of the filter.
inline Quaternion attitude_of(const Attitude& filter) {
  return rt::to_quaternion(filter.estimate().q_world_body);
}
/// Angle of the turn between two attitudes, rad.
inline double angle_between(const Quaternion& a, const Quaternion& b) {
  return norm(log_rotation(conjugate(a) * b));
}
/// Angle between the two ideas of up, rad.
inline double inclination_error(const Quaternion& a, const Quaternion& b) {
  const Vector3 up_a = rotate_back(a, {0, 0, 1});
  const Vector3 up_b = rotate_back(b, {0, 0, 1});
  return std::atan2(norm(cross(up_a, up_b)), dot(up_a, up_b));
}

/// Rates in rad/s and specific force in m/s^2, both in the body.
inline rt::ImuSample sample_of(rt::Nanoseconds stamp, const Vector3& gyr, const Vector3& acc,
                               std::uint32_t flags) {
  rt::ImuSample sample;
  sample.stamp_ns = stamp;
  rt::store(gyr, sample.gyr_rad_s);
  rt::store(acc, sample.acc_m_s2);
  sample.flags = flags;
  return sample;
}
inline constexpr std::uint32_t kBoth = rt::kImuGyr | rt::kImuAcc;
inline const Vector3 kGravity{0, 0, 9.81};

}  // namespace sortie::estimators::test
