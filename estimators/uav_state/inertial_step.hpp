// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning from an inertial sensor, and how its errors grow: the prediction of an error-state filter.
#pragma once

#include <array>
#include <cstddef>

#include "rt/rotation.hpp"

namespace sortie::estimators {

/// What is integrated, and the sensor's biases.
struct InertialState {
  rt::Vector3 p_world_m;
  rt::Vector3 v_world_m_s;
  rt::Quaternion q_world_body;
  rt::Vector3 gyr_bias_rad_s;
  rt::Vector3 acc_bias_m_s2;
  SORTIE_FIELDS(p_world_m, v_world_m_s, q_world_body, gyr_bias_rad_s, acc_bias_m_s2)
};

/// One reading: means over the interval that ends it.
struct InertialReading {
  double dt_s{};
  rt::Vector3 gyr_rad_s;
  rt::Vector3 acc_m_s2;
  SORTIE_FIELDS(dt_s, gyr_rad_s, acc_m_s2)
};

/// Densities of the sensor's errors.
struct InertialNoise {
  double gyr_rad_s_rt_hz{4e-4};
  double acc_m_s2_rt_hz{8e-3};
  double gyr_walk_rad_s_rt_s{2e-5};
  double acc_walk_m_s2_rt_s{3e-4};
};

inline constexpr std::size_t kErrorStates = 15;

/// Covariance of the errors of position, velocity (world), attitude (body), gyro bias, accelerometer bias, in
/// this order, three each; row by row.
struct ErrorCovariance {
  std::array<double, kErrorStates * kErrorStates> m{};
  SORTIE_FIELDS(m)

  double& operator()(std::size_t r, std::size_t c) { return m[r * kErrorStates + c]; }
  double operator()(std::size_t r, std::size_t c) const { return m[r * kErrorStates + c]; }

  /// Errors independent of each other: one standard deviation for each group of three.
  void set_groups(const double (&sigma)[5]) {
    m.fill(0.0);
    for (std::size_t i = 0; i < kErrorStates; ++i) (*this)(i, i) = sigma[i / 3] * sigma[i / 3];
  }
};

/// Moves the state over the reading; gravity points down the world's z. The attitude that the force is turned
/// by is that of the middle of the interval. Gives that attitude.
inline rt::Quaternion predict(InertialState& s, const InertialReading& r, double gravity_m_s2) {
  const rt::Vector3 w = r.gyr_rad_s - s.gyr_bias_rad_s;
  const rt::Vector3 f = r.acc_m_s2 - s.acc_bias_m_s2;
  const rt::Quaternion middle = s.q_world_body * rt::exp_rotation((0.5 * r.dt_s) * w);
  rt::Vector3 dv = r.dt_s * rt::rotate(middle, f);
  dv.z -= gravity_m_s2 * r.dt_s;
  s.p_world_m = s.p_world_m + r.dt_s * (s.v_world_m_s + 0.5 * dv);
  s.v_world_m_s = s.v_world_m_s + dv;
  s.q_world_body = rt::normalised(s.q_world_body * rt::exp_rotation(r.dt_s * w));
  return middle;
}

/// Moves the covariance over the reading that begins in `s`: P = F P F' + Q in blocks of three, 700 products.
void propagate(ErrorCovariance& p, const InertialState& s, const InertialReading& r,
               const InertialNoise& noise);

}  // namespace sortie::estimators
