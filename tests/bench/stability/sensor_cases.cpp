// SPDX-License-Identifier: BSD-3-Clause
// What an inertial sensor gives on bad days: samples that are missing, no numbers, absurd, clipped; pushes
// and blows.
#include <algorithm>
#include <cmath>
#include <random>

#include "estimators/attitude.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

using rt::Quaternion;
using rt::Vector3;

constexpr rt::Nanoseconds kStep = 10 * rt::kNanosecondsPerMillisecond;
constexpr double kStep_s = 0.01;
constexpr double kGravity = 9.81;

rt::ImuSample reading(int step, const Vector3& rate, const Vector3& force) {
  rt::ImuSample sample;
  sample.stamp_ns = step * kStep;
  rt::store(rate, sample.gyr_rad_s);
  rt::store(force, sample.acc_m_s2);
  sample.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
  return sample;
}

// Of the turn alone: no accelerometer, and no bias is learned.
rt::ImuSample turn_reading(int step, const Vector3& rate) {
  rt::ImuSample sample = reading(step, rate, {});
  sample.flags = rt::kImuGyr | rt::kImuMeanRate;
  return sample;
}

estimators::AttitudeConfig only_turning() {
  estimators::AttitudeConfig config;
  config.bias_sigma_initial_rad_s = 0;
  return config;
}

double lean(const double (&q)[4]) {
  const Vector3 up = rt::rotate(rt::normalised(rt::to_quaternion(q)), {0, 0, 1});
  return std::atan2(std::hypot(up.x, up.y), up.z);
}

// Inclination as a first filter has it: the direction of the force through a low-pass of 3 s.
class PlainInclination {
 public:
  void take(const Vector3& force) {
    mean_ = mean_ + (kStep_s / 3.0) * (force - mean_);
    worst_ = std::max(worst_, std::atan2(std::hypot(mean_.x, mean_.y), mean_.z));
  }
  double lean() const { return std::atan2(std::hypot(mean_.x, mean_.y), mean_.z); }
  double worst() const { return worst_; }

 private:
  Vector3 mean_{0, 0, kGravity};
  double worst_{};
};

}  // namespace

StabilityFigures lost_samples() {
  estimators::Attitude filter(only_turning());
  std::mt19937 random(20261101);
  const Vector3 rate{0, 0, 0.5};
  double naive = 0;
  static_cast<void>(filter.update(turn_reading(0, rate)));
  for (int i = 1; i <= 2000; ++i) {
    if (i < 2000 && random() % 20 == 0) continue;
    static_cast<void>(filter.update(turn_reading(i, rate)));
    naive += rate.z * kStep_s;
  }
  return {std::fabs(filter.estimate().delta_heading_rad - 10.0), std::fabs(naive - 10.0)};
}

StabilityFigures one_without_number() {
  estimators::Attitude filter(only_turning());
  const Vector3 rate{0, 0, 0.5};
  Quaternion naive;
  static_cast<void>(filter.update(turn_reading(0, rate)));
  for (int i = 1; i <= 1000; ++i) {
    const Vector3 read = i == 500 ? Vector3{0, 0, std::nan("")} : rate;
    static_cast<void>(filter.update(turn_reading(i, read)));
    naive = rt::normalised(naive * rt::exp_rotation(kStep_s * read));
  }
  const double yaw = 2 * std::atan2(naive.z, naive.w);
  return {std::fabs(filter.estimate().delta_heading_rad - 5.0),
          std::fabs(std::remainder(yaw - 5.0, 2 * M_PI))};
}

StabilityFigures one_absurd_force() {
  estimators::Attitude filter{estimators::AttitudeConfig{}};
  PlainInclination naive;
  for (int i = 0; i <= 4000; ++i) {
    const Vector3 force = i == 1000 ? Vector3{1e30, 0, kGravity} : Vector3{0, 0, kGravity};
    static_cast<void>(filter.update(reading(i, {1e-4, 0, 0}, force)));
    naive.take(force);
  }
  return {lean(filter.estimate().q_world_body), naive.lean()};
}

StabilityFigures fast_turn() {
  estimators::Attitude filter(only_turning());
  const Vector3 rate{0, 0, 100.0};
  Quaternion naive;
  static_cast<void>(filter.update(turn_reading(0, rate)));
  for (int i = 1; i <= 1000; ++i) {
    static_cast<void>(filter.update(turn_reading(i, rate)));
    const Quaternion slope = naive * Quaternion{0, rate.x, rate.y, rate.z};
    naive = rt::normalised({naive.w + 0.5 * kStep_s * slope.w, naive.x + 0.5 * kStep_s * slope.x,
                            naive.y + 0.5 * kStep_s * slope.y, naive.z + 0.5 * kStep_s * slope.z});
  }
  const Quaternion truth = rt::exp_rotation({0, 0, std::remainder(1000.0, 2 * M_PI)});
  const auto miss = [&truth](const Quaternion& q) { return norm(log_rotation(conjugate(q) * truth)); };
  return {miss(rt::normalised(rt::to_quaternion(filter.estimate().q_world_body))), miss(naive)};
}

StabilityFigures long_push() {
  estimators::Attitude filter{estimators::AttitudeConfig{}};
  PlainInclination naive;
  double worst = 0;
  double speed = 0;
  for (int i = 0; i <= 4000; ++i) {
    const double push = i > 1000 && i <= 2000 ? 3.0 : 0.0;
    speed += push * kStep_s;
    const Vector3 force{push, 0, kGravity};
    static_cast<void>(filter.set_track_speed(speed, i * kStep));
    filter.set_moving(speed > 0);
    static_cast<void>(filter.update(reading(i, {1e-4, 0, 0}, force)));
    naive.take(force);
    keep_worst(worst, lean(filter.estimate().q_world_body));
  }
  return {worst, naive.worst()};
}

StabilityFigures blows() {
  estimators::Attitude filter{estimators::AttitudeConfig{}};
  PlainInclination naive;
  double worst = 0;
  filter.set_moving(true);
  for (int i = 0; i <= 7000; ++i) {
    const bool struck = i >= 1000 && i % 100 == 50;  // in its first second a mean may itself be the outlier
    const Vector3 force{struck ? 160.0 : 0.0, 0, kGravity};
    static_cast<void>(filter.update(reading(i, {1e-4, 0, 0}, force)));
    naive.take(force);
    keep_worst(worst, lean(filter.estimate().q_world_body));
  }
  return {worst, naive.worst()};
}

StabilityFigures clipped_gyro() {
  estimators::AttitudeConfig config;
  config.gyr_range_rad_s = 35.0;
  estimators::Attitude filter(config);
  double turned = 0;
  for (int i = 0; i <= 2000; ++i) {
    const double rate = i > 500 && i <= 600 ? 50.0 : 0.0;
    turned += i > 0 ? rate * kStep_s : 0;
    static_cast<void>(filter.update(reading(i, {1e-4, 0, std::min(rate, 35.0)}, {0, 0, kGravity})));
  }
  double covariance[9];
  filter.covariance(covariance);
  // A heading that is not known at all has a deviation of half a turn over the root of three.
  const double miss = std::fabs(std::remainder(filter.estimate().delta_heading_rad - turned, 2 * M_PI));
  // A filter that takes what it reads has its gyro's noise alone to doubt: 1e-3 rad/sqrt(s) for 20 s.
  return {miss / std::sqrt(covariance[8]), miss / (1e-3 * std::sqrt(20.0))};
}

}  // namespace sortie::bench
