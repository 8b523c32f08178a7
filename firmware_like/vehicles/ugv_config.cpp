// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/vehicles/ugv_config.hpp"

#include "firmware_like/vehicles/units.hpp"

namespace sortie::firmware {

estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  estimators::AttitudeConfig config;
  for (int i = 0; i < 4; ++i) config.q_world_body[i] = builder.initial_pose().q_world_body[i];
  config.acc_time_constant_s = profile.number(
      "attitude.acc_time_constant_s",
      {config.acc_time_constant_s, 0.01, 100, "s", "low-pass of the specific force in the world frame"});
  config.bias_sigma_initial_rad_s = profile.number(
      "attitude.bias_sigma_rad_s",
      {config.bias_sigma_initial_rad_s, 0, 1, "rad/s", "sigma of the gyro bias at start; 0: no bias filter"});
  config.bias_forgetting_s = profile.number(
      "attitude.bias_forgetting_s",
      {config.bias_forgetting_s, 1, 1e6, "s", "in which the gyro bias walks by 0.1 deg/s, 1 sigma"});
  config.block_ns = milliseconds(
      profile.number("attitude.block_ms", {static_cast<double>(config.block_ns) * 1e-6, 0.001, 1000, "ms",
                                           "between looks at the accelerometer, the bias and rest"}));
  const char* arm = "place of the IMU, seen from the point whose speed the tracks tell";
  config.p_body_imu_m[0] = profile.number("imu.x_m", {0, -10, 10, "m", arm});
  config.p_body_imu_m[1] = profile.number("imu.y_m", {0, -10, 10, "m", arm});
  config.p_body_imu_m[2] = profile.number("imu.z_m", {0, -10, 10, "m", arm});
  config.max_rate_rad_s = profile.number("attitude.max_rate_rad_s", {config.max_rate_rad_s, 0.1, 1e4, "rad/s",
                                                                     "a faster reading is no reading"});
  config.max_coast_ns = milliseconds(
      profile.number("attitude.max_coast_ms", {static_cast<double>(config.max_coast_ns) * 1e-6, 1, 1e5, "ms",
                                               "longest gap bridged with a held rate"}));
  return config;
}

estimators::TrackOdometryConfig read_odometry_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  estimators::TrackOdometryConfig config;
  for (int i = 0; i < 3; ++i) config.p_world_body_m[i] = builder.initial_pose().p_world_body_m[i];
  const double scale =
      profile.number("odometry.scale", {1, 0.1, 10, "", "true metres per measured metre of both tracks"});
  config.scale_left = config.scale_right = scale;
  config.track_width_m = profile.number(
      "odometry.track_width_m",
      {0, 0, 10, "m", "distance of the tracks' turning centres, for the slip check; 0: no check"});
  config.max_speed_m_s =
      profile.number("odometry.max_speed_m_s",
                     {config.max_speed_m_s, 0.01, 100, "m/s", "a faster track is a counter that jumped"});
  config.max_extrapolation_ns = milliseconds(profile.number(
      "odometry.max_extrapolation_ms", {static_cast<double>(config.max_extrapolation_ns) * 1e-6, 0, 1e4, "ms",
                                        "how far behind the newest attitude a track sample may lie"}));
  return config;
}

}  // namespace sortie::firmware
