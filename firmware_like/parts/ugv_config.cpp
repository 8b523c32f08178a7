// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_config.hpp"

#include "estimators/turning_centre.hpp"

namespace sortie::firmware {

estimators::AttitudeConfig read_attitude_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  for (const char* path :
       {"groups.control.rate_hz", "imu.samples", "attitude.precision", "attitude.track_aid"})
    profile.knob(path);
  estimators::AttitudeConfig config;
  for (int i = 0; i < 4; ++i) config.q_world_body[i] = builder.initial_pose().q_world_body[i];
  profile.read("attitude", config);
  return config;
}

estimators::TrackOdometryConfig read_odometry_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  estimators::TrackOdometryConfig config;
  for (int i = 0; i < 3; ++i) config.p_world_body_m[i] = builder.initial_pose().p_world_body_m[i];
  profile.read("odometry", config);
  config.scale_right = config.scale_left;
  if (config.obstacles) {
    // [body]: the outline from the side. The robot's place, which every pose means, is on the ground between
    // the tracks; the estimator's own defaults, those of an Absolem-like vehicle, begin between the axles.
    constexpr double kRun_m = -0.07192;
    estimators::TrackProfile& body = config.obstacle.modes.profile;
    for (double* height_m : {&body.axle_m, &body.com_z_m, &body.pivot_z_m}) *height_m -= kRun_m;
    profile.read("body", body);
    config.icr_x_m = estimators::turning_centre_x_m(body);
  }
  config.icr_x_m = profile.number("odometry.icr_x_m",
                                  {config.icr_x_m, -10, 10, "m",
                                   "turning centre ahead of the place that poses mean; where a body is "
                                   "described it follows from that"});
  return config;
}

}  // namespace sortie::firmware
