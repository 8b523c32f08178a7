// SPDX-License-Identifier: BSD-3-Clause
// A flight for the flight estimator, and what its sensors say.
#pragma once

#include <cmath>
#include <random>

#include "estimators/uav_state/uav_estimator.hpp"
#include "rt/rotation.hpp"
#include "rt/samples.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::estimators::test {

using rt::Quaternion;
using rt::Vector3;

inline constexpr rt::Nanoseconds kStepNs = 5'000'000;  ///< of the inertial sensor

/// A body that hovers about, written down in closed form; its sensors with errors of known size.
class SimulatedFlight {
 public:
  explicit SimulatedFlight(std::uint64_t seed, double noise = 1.0) : random_(seed), noise_(noise) {
    gyr_bias_ = {0.002 * noise * normal(), 0.002 * noise * normal(), 0.002 * noise * normal()};
    acc_bias_ = {0.03 * noise * normal(), 0.03 * noise * normal(), 0.03 * noise * normal()};
  }
  // 0 before 0, 1 after 2, twice differentiable.
  static double softly(double s) {
    const double x = s < 0.0 ? 0.0 : (s > 2.0 ? 1.0 : 0.5 * s);
    return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
  }
  static Vector3 position(double t) {
    const double s = t - 1.0;
    const double soft = softly(s);
    return {soft * rt::sin(0.9 * s), soft * rt::sin(0.7 * s), soft * 0.5 * rt::sin(1.1 * s)};
  }
  static Quaternion attitude(double t) {
    const double s = t - 1.0;
    const double soft = softly(s);
    return rt::from_yaw_pitch_roll(0.4 + soft * 0.5 * rt::sin(0.5 * s), soft * 0.2 * rt::sin(1.3 * s),
                                   soft * 0.2 * rt::sin(1.7 * s));
  }
  static Vector3 velocity(double t) {
    constexpr double h = 1e-4;
    return (0.5 / h) * (position(t + h) - position(t - h));
  }
  rt::ImuSample imu(rt::Nanoseconds now_ns) {
    const double t = rt::to_seconds(now_ns);
    const double h = rt::to_seconds(kStepNs);
    const Vector3 turn = (1.0 / h) * rt::log_rotation(rt::conjugate(attitude(t - h)) * attitude(t));
    Vector3 dv = velocity(t) - velocity(t - h);
    dv.z += 9.81 * h;
    const Vector3 force = rt::rotate_back(attitude(t - 0.5 * h), (1.0 / h) * dv);
    const double gyr = 4e-4 * noise_ / std::sqrt(h);
    const double acc = 8e-3 * noise_ / std::sqrt(h);
    rt::ImuSample sample;
    sample.stamp_ns = now_ns;
    sample.flags = rt::kImuGyr | rt::kImuAcc;
    store_noisy(turn + gyr_bias_, gyr, sample.gyr_rad_s);
    store_noisy(force + acc_bias_, acc, sample.acc_m_s2);
    return sample;
  }
  rt::UavFix fix(rt::Nanoseconds stamp_ns) {
    const double t = rt::to_seconds(stamp_ns);
    rt::UavFix fix;
    fix.stamp_ns = stamp_ns;
    store_noisy(position(t), 0.012 * noise_, fix.p_world_m);
    fix.yaw_rad = rt::yaw_of(attitude(t)) + 0.012 * noise_ * normal();
    fix.flags = rt::kFixPosition | rt::kFixYaw;
    return fix;
  }
  const Vector3& gyr_bias() const { return gyr_bias_; }
  const Vector3& acc_bias() const { return acc_bias_; }

 private:
  double uniform() { return (static_cast<double>(random_() >> 11) + 0.5) * 0x1p-53; }
  double normal() {
    const double radius = std::sqrt(-2.0 * rt::log(uniform()));
    return radius * rt::cos(6.283185307179586 * uniform());
  }
  void store_noisy(const Vector3& v, double sigma, double (&out)[3]) {
    out[0] = v.x + sigma * normal();
    out[1] = v.y + sigma * normal();
    out[2] = v.z + sigma * normal();
  }
  std::mt19937_64 random_;
  double noise_;
  Vector3 gyr_bias_;
  Vector3 acc_bias_;
};

/// An estimator that knows the size of these errors.
inline UavEstimatorConfig matched_config() {
  UavEstimatorConfig config;
  config.noise.gyr_walk_rad_s_rt_s = 1e-6;
  config.noise.acc_walk_m_s2_rt_s = 1e-5;
  config.start_acc_bias_sigma_m_s2 = 0.03;
  config.start_tilt_sigma_rad = 0.001;
  return config;
}

}  // namespace sortie::estimators::test
