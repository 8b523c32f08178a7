// SPDX-License-Identifier: BSD-3-Clause
// Estimators under the campaign: attitude in double and in float, track odometry, UAV state.
#include <cmath>
#include <memory>

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "estimators/uav_state/uav_estimator.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"

namespace sortie::bench {

namespace {

rt::ImuSample imu_of(const CampaignOp& op, rt::Nanoseconds stamp_ns) {
  const auto& v = op.value;
  return {stamp_ns,
          {2.0 * v[0], 2.0 * v[1], 2.0 * v[2]},
          {3.0 * v[3], 3.0 * v[4], 9.81 + 3.0 * v[5]},
          rt::kImuGyr | rt::kImuAcc | (op.kind % 5 == 1 ? rt::kImuMeanRate : 0u) |
              (op.kind % 5 == 2 ? rt::kImuSaturated : 0u)};
}

bool is_unit(const double (&q)[4], double tolerance) {
  return std::fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) < tolerance;
}

template <class Real>
void run_attitude(CampaignTrial& trial, std::span<const CampaignOp> ops, double rounding) {
  estimators::AttitudeConfig config;
  config.p_body_imu_m[0] = 0.1;
  estimators::BasicAttitude<Real> filter(config);
  CampaignClock clock;
  std::uint64_t samples = 0;
  std::uint64_t said_ok = 0;
  for (const CampaignOp& op : ops) {
    const rt::Nanoseconds stamp = clock.step(op);
    if (op.kind % 5 == 3) {
      const rt::Vector3 v{2.0 * op.value[0], op.value[1], op.value[2]};
      trial.given(trial.real_time([&] { return filter.set_track_velocity(v, stamp); }));
      filter.set_moving(op.value[3] > 0.0);
      continue;
    }
    if (op.kind % 5 == 4 && op.value[6] > 0.8) {
      trial.given(
          trial.real_time([&] { return filter.set_heading(10.0 * op.value[0], std::fabs(op.value[1])); }));
    }
    const rt::ImuSample sample = imu_of(op, stamp);
    ++samples;
    said_ok += trial.answered(trial.real_time([&] { return filter.update(sample); })) == Status::ok ? 1 : 0;
    const rt::AttitudeEstimate& now = filter.estimate();
    trial.see(now, "the attitude is not finite");
    trial.need(is_unit(now.q_world_body, rounding), "the attitude's quaternion is not of length 1");
    for (const double bias : now.bias_rad_s)
      trial.need(std::fabs(bias) <= config.max_bias_rad_s * 1.0001, "the bias lies beyond its limit");
    double covariance[9];
    filter.covariance(covariance);
    trial.need(all_finite(covariance), "the covariance is not finite");
    for (const int i : {0, 4, 8}) trial.need(covariance[i] >= 0.0, "a variance lies below zero");
  }
  const estimators::AttitudeCounters& c = filter.counters();
  const std::uint64_t refused =
      c.not_finite + c.out_of_range + c.zero_rate + c.time_backwards + c.time_repeated + c.time_jumped;
  // One sample may be held until the next tells what it was; it was answered with ok.
  trial.need(c.used + refused == samples || c.used + refused + 1 == samples,
             "samples and counters do not add up");
  trial.need(said_ok >= c.used, "more samples were used than were answered with ok");
}

rt::AttitudeEstimate turned(const CampaignOp& op, rt::Nanoseconds stamp) {
  rt::AttitudeEstimate attitude;
  attitude.stamp_ns = stamp;
  const rt::Quaternion q = rt::exp_rotation({0.3 * op.value[0], 0.3 * op.value[1], 3.0 * op.value[2]});
  rt::store(q, attitude.q_world_body);
  if (op.value[3] > 1.0) attitude.q_world_body[0] = op.value[3];  // no rotation
  for (std::size_t i = 0; i < 3; ++i) attitude.w_body_rad_s[i] = op.value[4 + i % 3];
  return attitude;
}

}  // namespace

CampaignOutcome run_attitude_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  run_attitude<double>(trial, ops, 1e-9);
  run_attitude<float>(trial, ops, 1e-5);
  return trial.end();
}

CampaignOutcome run_odometry_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  estimators::TrackOdometryConfig config;
  config.track_width_m = 0.4;
  config.obstacles = !ops.empty() && ops[0].value[6] > 0.0;
  config.learn_steering = !ops.empty() && ops[0].value[5] > 0.0;
  const auto odometry = std::make_unique<estimators::TrackOdometry>(config);
  CampaignClock clock;
  double left = 0;
  double right = 0;
  std::uint64_t samples = 0;
  for (const CampaignOp& op : ops) {
    const rt::Nanoseconds stamp = clock.step(op);
    if (op.kind % 4 == 0) {
      const rt::AttitudeEstimate attitude = turned(op, stamp);
      trial.given(trial.real_time([&] { return odometry->observe(attitude); }));
    } else if (op.kind % 4 == 1) {
      trial.real_time([&] {
        odometry->feel(imu_of(op, stamp));
        return 0;
      });
    } else {
      if (op.kind % 4 == 3 && op.value[3] > 0.95) left = right = 0.0;  // the counters begin anew
      left += 0.02 * op.value[0];
      right += 0.02 * op.value[1];
      const rt::TrackSample sample{stamp, left, right, 0};
      ++samples;
      const double before = odometry->estimate().distance_m;
      const Status status = trial.answered(trial.real_time([&] { return odometry->update(sample); }));
      const double moved = odometry->estimate().distance_m - before;
      trial.need(moved >= 0.0, "the path grew shorter");
      trial.need(status == Status::ok || moved == 0.0, "a refused sample moved the pose");
      if (!std::isfinite(left)) left = 0.0;  // a counter is a counter again
      if (!std::isfinite(right)) right = 0.0;
    }
    const rt::PoseEstimate& now = odometry->estimate();
    trial.see(now, "the pose is not finite");
    trial.need(is_unit(now.q_world_body, 1e-9), "the pose's quaternion is not of length 1");
    for (int i = 0; i < 6; ++i) trial.need(now.covariance[7 * i] >= 0.0, "a variance lies below zero");
  }
  const estimators::TrackOdometryCounters& c = odometry->counters();
  trial.need(
      c.used + c.not_finite + c.out_of_range + c.time_backwards + c.time_repeated + c.time_jumped + c.jumps ==
          samples,
      "samples and counters do not add up");
  return trial.end();
}

CampaignOutcome run_uav_state_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  const auto estimator = std::make_unique<estimators::UavEstimator>(estimators::UavEstimatorConfig{});
  CampaignClock clock;
  std::uint64_t readings = 0;
  std::uint64_t fixes = 0;
  for (const CampaignOp& op : ops) {
    const bool is_fix = op.kind % 4 == 0;
    if (!is_fix) {
      rt::ImuSample sample = imu_of(op, clock.step(op));
      if (readings < 30) {  // stands at first, or nothing is ever levelled
        for (double& rate : sample.gyr_rad_s) rate *= 0.001;
        for (double& force : sample.acc_m_s2) force = force > 5.0 ? 9.81 : 0.01 * force;
      }
      ++readings;
      trial.given(trial.real_time([&] { return estimator->imu(sample, 9.81 + op.value[6]); }));
    } else {
      // Of now, of a while ago, of a time to come.
      const rt::Nanoseconds age = op.step_ns % 1'000'000 * whole_of(op.value[4], 4) % 1'000'000;
      const rt::UavFix fix{static_cast<std::int64_t>(static_cast<std::uint64_t>(clock.now_ns) -
                                                     static_cast<std::uint64_t>(age)),
                           {op.value[0], op.value[1], 2.0 + op.value[2]},
                           3.0 * op.value[3],
                           rt::kFixPosition | (op.value[5] > 0.0 ? rt::kFixYaw : 0u)};
      ++fixes;
      trial.given(trial.real_time([&] { return estimator->fix(fix); }));
    }
    const rt::UavState& now = estimator->state();
    trial.see(now, "the flight state is not finite");
    trial.need(is_unit(now.q_world_body, 1e-9), "the flight state's quaternion is not of length 1");
    for (const double sigma : now.position_sigma_m) trial.need(sigma >= 0.0, "a deviation lies below zero");
  }
  const estimators::UavEstimatorCounters& c = estimator->counters();
  trial.need(c.imu_used + c.imu_refused == readings, "readings and counters do not add up");
  trial.need(c.fixes_used + c.fixes_refused + c.fixes_gated == fixes, "fixes and counters do not add up");
  return trial.end();
}

}  // namespace sortie::bench
