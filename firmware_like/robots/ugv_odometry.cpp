// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's odometry: what it is given each job, and what it tells about itself.
#include <tuple>

#include "firmware_like/parts/odometry_state.hpp"
#include "firmware_like/robots/ugv.hpp"
#include "firmware_like/robots/ugv_config.hpp"
#include "firmware_like/runtime/live_keys.hpp"

namespace sortie::firmware {

void Ugv::add_odometry(VehicleBuilder& builder, rt::GroupId group) {
  std::tie(tracks_, track_port_) = builder.stream<rt::TrackSample>(group, "TRACK", 128, 32);
  const estimators::TrackOdometryConfig config = read_odometry_config(builder);
  obstacles_ = config.obstacles;
  obstacle_flippers_ = obstacles_ && config.obstacle.modes.profile.flippers;
  if (rt::kBuilt<rt::Part::obstacles> && obstacle_flippers_) listen_to_flippers(builder, group);
  odometry_ = std::make_unique<estimators::TrackOdometry>(config);
  live_keys<estimators::TrackOdometryConfig>(builder, group, "odometry", *odometry_);
  odometry_task_ = builder.task<rt::PoseEstimate>(group, "odometry", 50,
                                                  [this](rt::JobContext&, rt::PoseEstimate& output) {
                                                    run_odometry();
                                                    output = odometry_->estimate();
                                                  });
  builder.remembers(odometry_task_, *odometry_);
  add_odometry_counters(builder);
  // What a scene with obstacles asks about every day, a flat one asks for when it is in doubt.
  if (builder.wants("odometry_state", obstacles_)) add_odometry_state(builder, group);
}

/// The flippers' angles are read by the odometry and by the flippers' own task; whoever comes first asks.
void Ugv::listen_to_flippers(VehicleBuilder& builder, rt::GroupId group) {
  if (flipper_states_ != nullptr) return;
  std::tie(flipper_states_, flipper_port_) = builder.stream<rt::FlipperSample>(group, "FLIPPER", 64, 16);
}

/// One job. What is refused is counted by the odometry, by reason.
void Ugv::run_odometry() {
  if (obstacle_flippers_ && flipper_states_->size() > 0) {
    const rt::FlipperSample& newest = *(flipper_states_->end() - 1);
    odometry_->set_flippers({0.5 * (newest.angle_rad[0] + newest.angle_rad[1]),
                             0.5 * (newest.angle_rad[2] + newest.angle_rad[3])});
  }
  for (std::uint32_t i = 0; i < job_attitude_count_; ++i) {
    static_cast<void>(odometry_->observe(job_attitudes_[i]));
    if (obstacles_) odometry_->feel(*job_samples_[i]);
  }
  for (const rt::TrackSample& sample : *tracks_) static_cast<void>(odometry_->update(sample));
}

void Ugv::add_odometry_counters(VehicleBuilder& builder) {
  const estimators::TrackOdometry* odometry = odometry_.get();
  builder.counter("track_used", [odometry] { return odometry->counters().used; });
  builder.uses("TRACK", [odometry] { return odometry->counters().used; });
  builder.counter("track_not_finite", [odometry] { return odometry->counters().not_finite; });
  builder.counter("track_time_backwards", [odometry] { return odometry->counters().time_backwards; });
  builder.counter("track_jumps", [odometry] { return odometry->counters().jumps; });
  builder.counter("track_slips", [odometry] { return odometry->counters().slips; });
}

void Ugv::add_odometry_state(VehicleBuilder& builder, rt::GroupId group) {
  const rt::TaskBase* task = builder.task<OdometryState>(
      group, "odometry_state", 10, [this](rt::JobContext&, OdometryState& output) {
        output = odometry_state(*odometry_, attitude_->estimate(), attitude_->counters());
      });
  builder.remembers(task);  // it only looks at what the other two remember
}

}  // namespace sortie::firmware
