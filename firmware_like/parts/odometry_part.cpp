// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's odometry: what it is given each job, and what it tells about itself.
#include "firmware_like/parts/odometry_part.hpp"

#include "drivers/can_frames.hpp"
#include "drivers/ugv_drives.hpp"
#include "estimators/turning_centre.hpp"
#include "firmware_like/parts/odometry_state.hpp"
#include "firmware_like/parts/own_frames.hpp"
#include "firmware_like/runtime/live_keys.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

rt::Stream<rt::FlipperSample>* flipper_states(VehicleBuilder& builder, rt::GroupId group) {
  return builder.stream<rt::FlipperSample>(group, "FLIPPER", 64, 16).first;
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

OdometryPart::OdometryPart(VehicleBuilder& builder)
    : attitude_(*builder.find<AttitudePart>()),
      tracks_(builder.stream<rt::TrackSample>(attitude_.group(), "TRACK", 128, 32).first) {
  const rt::GroupId group = attitude_.group();
  const estimators::TrackOdometryConfig config = read_odometry_config(builder);
  obstacles_ = config.obstacles;
  if (rt::kBuilt<"obstacles"> && obstacles_ && config.obstacle.modes.profile.flippers)
    flippers_ = flipper_states(builder, group);
  odometry_ = std::make_unique<estimators::TrackOdometry>(config);
  builder.offer(*this);
  attitude_.set_aid([this](ChosenAttitude& filter) { tell(filter); });
  live_keys<estimators::TrackOdometryConfig>(builder, group, "odometry", *odometry_);
  task_ = builder.task<rt::PoseEstimate>(group, "odometry", 50,
                                         [this](rt::JobContext&, rt::PoseEstimate& output) {
                                           run();
                                           output = odometry_->estimate();
                                         });
  builder.offer(*task_);
  builder.remembers(task_, *odometry_);
  builder.counters("track_", odometry_->counters());
  builder.uses("TRACK", [this] { return odometry_->counters().used; });
  // What a scene with obstacles asks about every day, a flat one asks for when it is in doubt.
  if (builder.wants("odometry_state", obstacles_)) add_state(builder);
}

/// A backward read: the tracks' velocity of the job before.
void OdometryPart::tell(ChosenAttitude& filter) const {
  const rt::PoseEstimate& pose = odometry_->estimate();
  // Before its first sample the odometry has nothing to tell. A velocity that is not finite is no aid; the
  // odometry counts what made it so.
  if ((pose.flags & estimators::kPoseStarted) == 0) return;
  filter.with([this, &pose](auto& chosen) {
    chosen.set_moving(odometry_->belts_run());
    if (attitude_.wants_track_aid() && odometry_->velocity_known())
      static_cast<void>(chosen.set_track_velocity(rt::to_vector(pose.v_body_m_s), pose.stamp_ns));
  });
}

/// One job. What is refused is counted by the odometry, by reason.
void OdometryPart::run() {
  if (flippers_ != nullptr && flippers_->size() > 0) {
    const rt::FlipperSample& newest = *(flippers_->end() - 1);
    odometry_->set_flippers({0.5 * (newest.angle_rad[0] + newest.angle_rad[1]),
                             0.5 * (newest.angle_rad[2] + newest.angle_rad[3])});
  }
  for (const AttitudePart::Step& step : attitude_.steps()) {
    static_cast<void>(odometry_->observe(step.attitude));
    if (obstacles_) odometry_->feel(*step.sample);
  }
  for (const rt::TrackSample& sample : *tracks_) static_cast<void>(odometry_->update(sample));
}

void OdometryPart::add_state(VehicleBuilder& builder) {
  const rt::TaskBase* task = builder.task<OdometryState>(
      attitude_.group(), "odometry_state", 10, [this](rt::JobContext&, OdometryState& output) {
        attitude_.filter().with([this, &output](const auto& filter) {
          output = odometry_state(*odometry_, filter.estimate(), filter.counters());
        });
      });
  builder.remembers(task);  // it only looks at what the other two remember
}

void OdometryPart::finish(VehicleBuilder& builder) {
  if (builder.find<drivers::UgvDrives>() != nullptr) return;  // those have said theirs
  using namespace drivers;
  const std::uint32_t tracks[] = {kCanTrackLeftId, kCanTrackRightId};
  const std::uint32_t states[] = {kCanFlipperStateId, kCanFlipperStateId + 1, kCanFlipperStateId + 2,
                                  kCanFlipperStateId + 3};
  add_device_frames(builder, tracks, "can.track_hz", 100, "how often the tracks' encoders send");
  if (builder.find_port<rt::FlipperSample>("FLIPPER") != nullptr)
    add_device_frames(builder, states, "can.flipper_hz", 100, "how often the flippers tell their state");
}

std::unique_ptr<Part> make_odometry(VehicleBuilder& builder) {
  return std::make_unique<OdometryPart>(builder);
}

}  // namespace sortie::firmware
