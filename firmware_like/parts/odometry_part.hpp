// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning from tracks and attitude, as a part of the ground robot.
#pragma once

#include "estimators/track_odometry.hpp"
#include "firmware_like/parts/attitude_part.hpp"
#include "firmware_like/parts/part.hpp"

namespace sortie::firmware {

/// Reader of [odometry] and [body]. Throws ProfileError.
estimators::TrackOdometryConfig read_odometry_config(VehicleBuilder& builder);

/// Group `control`, behind the attitude: tasks `odometry` and, where it is asked for, `odometry_state`. Gives
/// the attitude the tracks' velocity of the job before.
class OdometryPart final : public Part {
 public:
  explicit OdometryPart(VehicleBuilder& builder);

  const rt::Stream<rt::TrackSample>& tracks() const { return *tracks_; }
  const rt::Task<rt::PoseEstimate>* pose_task() const override { return task_; }
  void finish(VehicleBuilder& builder) override;

 private:
  void add_state(VehicleBuilder& builder);
  void run();
  void tell(ChosenAttitude& filter) const;

  AttitudePart& attitude_;
  rt::Stream<rt::TrackSample>* tracks_{};
  rt::Stream<rt::FlipperSample>* flippers_{};  // null where nothing follows from their angles
  bool obstacles_{};
  std::unique_ptr<estimators::TrackOdometry> odometry_;
  rt::Task<rt::PoseEstimate>* task_{};
};

/// The stream of the flippers' angles, which the odometry and the flippers' own task read.
rt::Stream<rt::FlipperSample>* flipper_states(VehicleBuilder& builder, rt::GroupId group);

}  // namespace sortie::firmware
