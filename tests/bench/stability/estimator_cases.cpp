// SPDX-License-Identifier: BSD-3-Clause
// What the estimators are given on bad days: wrong stamps, fast cones, a whole day, wide steps.
#include <algorithm>
#include <array>
#include <cmath>

#include "estimators/attitude.hpp"
#include "estimators/slow_value.hpp"
#include "estimators/turning_centre.hpp"
#include "mapping/grid/pose_history.hpp"
#include "tests/bench/stability/cases.hpp"

namespace sortie::bench {

namespace {

using rt::Quaternion;
using rt::Vector3;

constexpr rt::Nanoseconds kTenMs = 10 * rt::kNanosecondsPerMillisecond;

rt::ImuSample turn_sample(rt::Nanoseconds stamp_ns, const Vector3& rate) {
  rt::ImuSample sample;
  sample.stamp_ns = stamp_ns;
  rt::store(rate, sample.gyr_rad_s);
  sample.flags = rt::kImuGyr | rt::kImuMeanRate;
  return sample;
}

// No bias is learned: what is tried is the way that a turn takes.
estimators::AttitudeConfig turning_from(const Quaternion& q) {
  estimators::AttitudeConfig config;
  rt::store(q, config.q_world_body);
  config.bias_sigma_initial_rad_s = 0;
  return config;
}

double angle_off(const double (&q)[4], const Quaternion& truth) {
  return norm(log_rotation(conjugate(rt::normalised(rt::to_quaternion(q))) * truth));
}

using Angles = std::array<double, 3>;  // yaw, pitch, roll

Angles angle_rates(const Angles& a, const Vector3& w) {
  const rt::SinCos roll = rt::sincos(a[2]);
  const double across = w.y * roll.sin + w.z * roll.cos;
  const rt::SinCos pitch = rt::sincos(a[1]);
  return {across / pitch.cos, w.y * roll.cos - w.z * roll.sin, w.x + across * pitch.sin / pitch.cos};
}

// Runge and Kutta's fourth order: away from the pole it is good to 1e-9.
Angles after_step(const Angles& a, const Vector3& w, double dt) {
  const auto moved = [&a](const Angles& rate, double by) {
    return Angles{a[0] + by * rate[0], a[1] + by * rate[1], a[2] + by * rate[2]};
  };
  const Angles k1 = angle_rates(a, w);
  const Angles k2 = angle_rates(moved(k1, 0.5 * dt), w);
  const Angles k3 = angle_rates(moved(k2, 0.5 * dt), w);
  const Angles k4 = angle_rates(moved(k3, dt), w);
  Angles sum;
  for (std::size_t i = 0; i < 3; ++i) sum[i] = (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) / 6;
  return moved(sum, dt);
}

}  // namespace

StabilityFigures gimbal_lock() {
  const Vector3 rate{0.02, 1.0, 0.03};
  const Quaternion start = rt::from_yaw_pitch_roll(0.4, 1.2, 0.0);
  estimators::Attitude filter(turning_from(start));
  Angles angles{0.4, 1.2, 0.0};
  static_cast<void>(filter.update(turn_sample(0, rate)));
  for (int i = 1; i <= 1000; ++i) {
    static_cast<void>(filter.update(turn_sample(i * kTenMs, rate)));
    angles = after_step(angles, rate, 0.01);
  }
  const Quaternion truth = start * rt::exp_rotation(10.0 * rate);
  const Quaternion by_angles = rt::from_yaw_pitch_roll(angles[0], angles[1], angles[2]);
  return {angle_off(filter.estimate().q_world_body, truth), norm(log_rotation(conjugate(by_angles) * truth))};
}

StabilityFigures repeated_samples() {
  estimators::Attitude filter(turning_from({}));
  const Vector3 rate{0, 0, 0.5};
  double naive = 0;
  static_cast<void>(filter.update(turn_sample(0, rate)));
  for (int i = 1; i <= 1000; ++i) {
    for (int copy = 0; copy < 2; ++copy) {
      static_cast<void>(filter.update(turn_sample(i * kTenMs, rate)));
      naive += 0.5 * 0.01;  // the rate is known, so is the step
    }
  }
  return {std::fabs(filter.estimate().delta_heading_rad - 5.0), std::fabs(naive - 5.0)};
}

StabilityFigures zero_interval() {
  mapping::PoseHistory history;
  const mapping::StampedPose first{kTenMs, {1, 0, 0}, {}};
  const mapping::StampedPose again{kTenMs, {1, 0, 0}, {}};
  static_cast<void>(history.add(first));
  static_cast<void>(history.add(again));
  mapping::StampedPose pose;
  if (history.at(kTenMs, 0, pose) != Status::ok) pose.p.x = std::nan("");
  const double share =
      static_cast<double>(kTenMs - first.stamp_ns) / static_cast<double>(again.stamp_ns - first.stamp_ns);
  return {std::fabs(pose.p.x - 1), std::fabs(first.p.x + share * (again.p.x - first.p.x) - 1)};
}

StabilityFigures huge_interval() {
  estimators::Attitude filter(turning_from({}));
  const Vector3 rate{0, 0, 0.5};
  double naive = 0;
  rt::Nanoseconds last = 0;
  const auto give = [&](rt::Nanoseconds stamp_ns) {
    static_cast<void>(filter.update(turn_sample(stamp_ns, rate)));
    if (stamp_ns <= last) return;
    naive += 0.5 * rt::to_seconds(stamp_ns - last);
    last = stamp_ns;
  };
  give(0);
  for (int i = 1; i <= 1000; ++i) {
    give(i * kTenMs);
    if (i == 500) give(i * kTenMs + 3600 * rt::kNanosecondsPerSecond);
  }
  return {std::fabs(filter.estimate().delta_heading_rad - 5.0), std::fabs(naive - 5.0)};
}

StabilityFigures coning() {
  constexpr double kCone = 0.05;                // half of its opening, rad
  constexpr double kSpeed = 62.83185307179586;  // 10 Hz
  const auto truth_at = [](double t) {
    const rt::SinCos half = rt::sincos(0.5 * kCone);
    const rt::SinCos phase = rt::sincos(kSpeed * t);
    return Quaternion{half.cos, half.sin * phase.cos, half.sin * phase.sin, 0};
  };
  // The body's rate is kSpeed (-sin c sin p, sin c cos p, cos c - 1) at phase p: means over a step in closed
  // form.
  const rt::SinCos cone = rt::sincos(kCone);
  Quaternion naive = truth_at(0);
  estimators::Attitude filter(turning_from(naive));
  constexpr int kSteps = 1000;
  for (int i = 0; i <= kSteps; ++i) {
    const rt::SinCos from = rt::sincos(kSpeed * 0.01 * (i - 1));
    const rt::SinCos to = rt::sincos(kSpeed * 0.01 * i);
    const Vector3 turned{cone.sin * (to.cos - from.cos), cone.sin * (to.sin - from.sin),
                         kSpeed * 0.01 * (cone.cos - 1)};
    static_cast<void>(filter.update(turn_sample(i * kTenMs, 100.0 * turned)));
    if (i > 0) naive = naive * rt::exp_rotation(turned);
  }
  const Quaternion truth = truth_at(0.01 * kSteps);
  return {angle_off(filter.estimate().q_world_body, truth),
          norm(log_rotation(conjugate(rt::normalised(naive)) * truth))};
}

StabilityFigures day_in_float() {
  // The earth's turn, about. Steps of 1/64 s and rates in powers of two: no rounding but the integration's.
  constexpr rt::Nanoseconds kStepNs = 15'625'000;
  constexpr int kSteps = 24 * 3600 * 64;
  const Vector3 rate{0x1p-15, 0x1p-16, 0x1p-14};
  estimators::AttitudeFloat filter(turning_from({}));
  estimators::QuaternionOf<float> naive;
  const auto turn = estimators::quaternion_of<float>(rt::exp_rotation((1.0 / 64) * rate));
  static_cast<void>(filter.update(turn_sample(0, rate)));
  for (int i = 1; i <= kSteps; ++i) {
    static_cast<void>(filter.update(turn_sample(i * kStepNs, rate)));
    naive = naive * turn;
    const float s =
        1.0f / std::sqrt(naive.w * naive.w + naive.x * naive.x + naive.y * naive.y + naive.z * naive.z);
    naive = {s * naive.w, s * naive.x, s * naive.y, s * naive.z};
  }
  const Quaternion truth = rt::exp_rotation(24 * 3600.0 * rate);
  return {angle_off(filter.estimate().q_world_body, truth),
          norm(log_rotation(conjugate(rt::normalised(widened(naive))) * truth))};
}

StabilityFigures tiny_increments() {
  constexpr int kCount = 10'000'000;
  constexpr float kBy = 1e-9f;
  float value = 1.0f;
  float error = 0.0f;
  float naive = 1.0f;
  for (int i = 0; i < kCount; ++i) {
    estimators::add_exactly(value, error, kBy);
    naive += kBy;
  }
  const double truth = 1.0 + kCount * static_cast<double>(kBy);
  return {std::fabs(static_cast<double>(value) - truth), std::fabs(static_cast<double>(naive) - truth)};
}

StabilityFigures slow_value_wide_steps() {
  constexpr double kTau = 0.01;
  constexpr double kStep = 1.0;
  estimators::SlowValue<double> slow;
  double naive = 0;
  StabilityFigures worst;
  for (int i = 0; i < 100; ++i) {
    slow.take(1.0, estimators::SlowStep<double>(kStep, 10.0, kTau));
    naive += kStep / kTau * (1.0 - naive);
    keep_worst(worst.ours, std::fabs(slow.value - 1));
    keep_worst(worst.naive, std::fabs(naive - 1));
  }
  return worst;
}

StabilityFigures balanced_load() {
  StabilityFigures worst;
  for (const double c : {1e-9, 1e-12, 0.0}) {
    estimators::TrackProfile profile;
    profile.com_x_m = c;
    const double a = profile.half_length_m;
    const double naive = (-2 * a * a + std::sqrt(4 * a * a * a * a + 36 * c * c * a * a)) / (6 * c);
    const double off = std::fabs(naive - 1.5 * c);
    keep_worst(worst.ours, std::fabs(estimators::turning_centre_x_m(profile) - 1.5 * c));
    keep_worst(worst.naive, off);
  }
  return worst;
}

}  // namespace sortie::bench
