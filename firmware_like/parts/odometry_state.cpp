// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/odometry_state.hpp"

#include <algorithm>
#include <cmath>

#include "rt/rotation.hpp"

namespace sortie::firmware {

namespace {

std::uint32_t health_of(std::uint32_t pose, std::uint32_t attitude, std::uint32_t mode, bool turns_known) {
  std::uint32_t health = 0;
  const auto say = [&health](bool bad, OdometryHealth bit) { health |= bad ? bit : 0u; };
  say((pose & estimators::kPoseStarted) == 0, kOdometryNotStarted);
  say((attitude & estimators::kAttitudeLevelled) == 0, kOdometryNotLevelled);
  say((pose & estimators::kPoseAttitudeStale) != 0, kOdometryAttitudeStale);
  say((pose & estimators::kPoseTravelUnknown) != 0, kOdometryTravelUnknown);
  say((attitude & estimators::kAttitudeHeadingInvalid) != 0, kOdometryHeadingInvalid);
  say((attitude & estimators::kAttitudeSaturated) != 0, kOdometrySaturated);
  say((attitude & estimators::kAttitudeCoasted) != 0, kOdometryCoasted);
  say((attitude & estimators::kAttitudeAidRefused) != 0, kOdometryAidRefused);
  say((pose & estimators::kPoseSlip) != 0, kOdometrySlip);
  say(mode == static_cast<std::uint32_t>(estimators::ObstacleMode::airborne), kOdometryAirborne);
  say(!turns_known, kOdometryTurnsUnknown);
  return health;
}

}  // namespace

OdometryState odometry_state(const estimators::TrackOdometry& odometry, const rt::AttitudeEstimate& attitude,
                             const estimators::AttitudeCounters& imu) {
  const rt::PoseEstimate& pose = odometry.estimate();
  const estimators::ObstacleState obstacle = odometry.obstacle();
  const estimators::TrackOdometryCounters& track = odometry.counters();
  OdometryState state;
  state.stamp_ns = pose.stamp_ns;
  state.mode = obstacle.mode;
  state.confidence = obstacle.confidence;
  state.step_height_m = obstacle.step_height_m;
  state.vertical_m_s = rotate(rt::to_quaternion(pose.q_world_body), rt::to_vector(pose.v_body_m_s)).z;
  state.sigma_horizontal_m = std::sqrt(std::max({0.0, pose.covariance[0], pose.covariance[7]}));
  state.sigma_vertical_m = std::sqrt(std::max(0.0, pose.covariance[14]));
  state.steering_efficiency = odometry.steering().value();
  state.turning_width_m = odometry.steering().centres_apart_m();
  state.slip = (pose.flags & estimators::kPoseSlip) != 0 ? 1u : 0u;
  state.health = health_of(pose.flags, attitude.flags, obstacle.mode, odometry.steering().trusted());
  state.slips = track.slips;
  state.imu_used = imu.used;
  state.imu_not_finite = imu.not_finite;
  state.imu_out_of_range = imu.out_of_range;
  state.imu_zero_rate = imu.zero_rate;
  state.imu_time = imu.time_backwards + imu.time_repeated + imu.time_jumped;
  state.imu_gaps = imu.gaps;
  state.imu_saturated = imu.saturated;
  state.imu_shortened = imu.shortened;
  state.imu_aid_refused = imu.aid_refused;
  state.track_used = track.used;
  state.track_not_finite = track.not_finite;
  state.track_out_of_range = track.out_of_range;
  state.track_time = track.time_backwards + track.time_repeated + track.time_jumped;
  state.track_jumps = track.jumps;
  state.track_resets = track.resets;
  state.track_no_attitude = track.no_attitude;
  state.track_attitude_stale = track.attitude_stale;
  state.attitude_refused = track.attitude_refused;
  return state;
}

}  // namespace sortie::firmware
