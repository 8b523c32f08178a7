// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_config.hpp"

#include "estimators/turning_centre.hpp"
#include "firmware_like/scene/units.hpp"

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

namespace {

/// [body]: the outline from the side, as the odometry's obstacle modes see it. The robot's place, which every
/// pose means, is on the ground between the tracks; the defaults are those of an Absolem-like vehicle.
estimators::TrackProfile read_track_profile(Profile& profile) {
  constexpr double kRun_m = -0.07192;  // of the estimator's own defaults, which begin between the axles
  estimators::TrackProfile body;
  const auto number = [&profile](const char* path, double& value, double low, double high,
                                 const char* meaning) {
    value = profile.number(path, {value, low, high, "m", meaning});
  };
  body.axle_m -= kRun_m;
  body.com_z_m -= kRun_m;
  body.pivot_z_m -= kRun_m;
  number("body.half_length_m", body.half_length_m, 0.01, 10, "from the middle of a track to a wheel's axle");
  number("body.radius_m", body.radius_m, 0.001, 10, "of the wheels, belt and grousers included");
  number("body.axle_m", body.axle_m, -10, 10, "height of the axles above the place that poses mean");
  number("body.half_width_m", body.half_width_m, 0.01, 10, "from the middle to the middle of a track");
  number("body.com_x_m", body.com_x_m, -10, 10, "centre of mass ahead of the place that poses mean");
  number("body.com_z_m", body.com_z_m, -10, 10, "centre of mass above it");
  body.flippers = profile.flag("body.flippers", true, "it has flippers, and they can carry it");
  if (!body.flippers) return body;
  number("body.pivot_x_m", body.pivot_x_m, 0, 10, "the front flippers' joint ahead, the rear ones' behind");
  number("body.pivot_z_m", body.pivot_z_m, -10, 10, "and above the place that poses mean");
  number("body.pivot_radius_m", body.pivot_radius_m, 0.001, 10, "of the wheel around the joint");
  number("body.flipper_m", body.flipper_m, 0.001, 10, "from the joint to the tip's axle");
  number("body.tip_radius_m", body.tip_radius_m, 0.001, 10, "of the wheel at the tip");
  return body;
}

}  // namespace

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
  config.learn_steering =
      profile.text(
          "odometry.steering", "fixed",
          "slip is judged by the turn that the tracks' distance claims, or by what the gyro has shown",
          {"fixed", "learned"}) == "learned";
  config.obstacles = profile.text("odometry.obstacles", "off",
                                  "on: edges, falls and flippers are known; off: all ground is a plane, "
                                  "nothing is there or runs for more",
                                  {"on", "off"}) == "on";
  if (config.obstacles) {
    config.obstacle.modes.profile = read_track_profile(profile);
    config.icr_x_m = estimators::turning_centre_x_m(config.obstacle.modes.profile);
  }
  config.icr_x_m = profile.number("odometry.icr_x_m",
                                  {config.icr_x_m, -10, 10, "m",
                                   "turning centre ahead of the place that poses mean; where a body is "
                                   "described it follows from that"});
  return config;
}

}  // namespace sortie::firmware
