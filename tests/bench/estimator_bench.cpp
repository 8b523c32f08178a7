// SPDX-License-Identifier: BSD-3-Clause
// One update of the attitude filter and of the track odometry, beside the least that could be done instead:
// integrating the gyro and the tracks without check, correction or covariance.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "tests/bench/vqf_peer.hpp"

namespace {

using namespace sortie;

constexpr rt::Nanoseconds kStep = 5 * rt::kNanosecondsPerMillisecond;

rt::ImuSample imu_at(std::int64_t i) {
  const double turn = 0.3 + 0.1 * static_cast<double>(i % 7);
  return {i * kStep,
          {0.01 * static_cast<double>(i % 5), -0.02, turn},
          {0.1, 0.05, 9.8},
          rt::kImuGyr | rt::kImuAcc};
}

void attitude_sortie(benchmark::State& state) {
  estimators::Attitude attitude{estimators::AttitudeConfig{}};
  std::int64_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(attitude.update(imu_at(++i)));
  if (attitude.counters().used != static_cast<std::uint64_t>(i)) state.SkipWithError("samples were refused");
}
BENCHMARK(attitude_sortie)->Name("attitude_update/sortie");

void attitude_float(benchmark::State& state) {
  estimators::AttitudeFloat attitude{estimators::AttitudeConfig{}};
  std::int64_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(attitude.update(imu_at(++i)));
}
BENCHMARK(attitude_float)->Name("attitude_update/in float");

void attitude_vqf(benchmark::State& state) {
  bench::VqfPeer peer(static_cast<double>(kStep) * 1e-9);
  std::int64_t i = 0;
  for (auto _ : state) {
    const rt::ImuSample imu = imu_at(++i);
    peer.update({imu.gyr_rad_s[0], imu.gyr_rad_s[1], imu.gyr_rad_s[2]},
                {imu.acc_m_s2[0], imu.acc_m_s2[1], imu.acc_m_s2[2]});
    benchmark::DoNotOptimize(peer.attitude());
  }
}
BENCHMARK(attitude_vqf)->Name("attitude_update/VQF, six axes, both bias estimators, unchecked");

void attitude_bare(benchmark::State& state) {
  double q[4]{1, 0, 0, 0};
  std::int64_t i = 0;
  for (auto _ : state) {
    const rt::ImuSample imu = imu_at(++i);
    const double half = 0.5 * static_cast<double>(kStep) * 1e-9;
    const double x = imu.gyr_rad_s[0] * half;
    const double y = imu.gyr_rad_s[1] * half;
    const double z = imu.gyr_rad_s[2] * half;
    const double w0 = q[0] - q[1] * x - q[2] * y - q[3] * z;
    const double w1 = q[1] + q[0] * x + q[2] * z - q[3] * y;
    const double w2 = q[2] + q[0] * y + q[3] * x - q[1] * z;
    const double w3 = q[3] + q[0] * z + q[1] * y - q[2] * x;
    const double inverse = 1 / std::sqrt(w0 * w0 + w1 * w1 + w2 * w2 + w3 * w3);
    q[0] = w0 * inverse;
    q[1] = w1 * inverse;
    q[2] = w2 * inverse;
    q[3] = w3 * inverse;
    benchmark::DoNotOptimize(q);
  }
}
BENCHMARK(attitude_bare)->Name("attitude_update/gyro alone, first order, unchecked");

void odometry_sortie(benchmark::State& state) {
  estimators::TrackOdometryConfig config;
  config.track_width_m = 0.4;
  estimators::TrackOdometry odometry{config};
  estimators::Attitude attitude{estimators::AttitudeConfig{}};
  static_cast<void>(attitude.update(imu_at(0)));
  rt::AttitudeEstimate turned = attitude.estimate();
  std::int64_t i = 0;
  std::uint64_t refused = 0;
  for (auto _ : state) {
    ++i;
    turned.stamp_ns = i * kStep;
    refused += odometry.observe(turned) == Status::ok ? 0 : 1;
    refused += odometry.update({i * kStep, 0.001 * static_cast<double>(i), 0.0011 * static_cast<double>(i),
                                0}) == Status::ok
                   ? 0
                   : 1;
  }
  if (refused != 0) state.SkipWithError("samples were refused");
}
BENCHMARK(odometry_sortie)->Name("odometry_update/sortie");

void odometry_bare(benchmark::State& state) {
  double x = 0;
  double y = 0;
  double last = 0;
  std::int64_t i = 0;
  for (auto _ : state) {
    ++i;
    const double travel = 0.00105 * static_cast<double>(i);
    const double heading = 0.00025 * static_cast<double>(i);
    x += (travel - last) * std::cos(heading);
    y += (travel - last) * std::sin(heading);
    last = travel;
    benchmark::DoNotOptimize(x);
    benchmark::DoNotOptimize(y);
  }
}
BENCHMARK(odometry_bare)->Name("odometry_update/plane, no covariance, unchecked");

}  // namespace
