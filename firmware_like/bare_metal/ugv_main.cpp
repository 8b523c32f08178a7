// SPDX-License-Identifier: BSD-3-Clause
// A ground robot's odometry on a bare board: attitude and track odometry at 500 Hz.
#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "firmware_like/bare_metal/run.hpp"

using namespace sortie;

namespace {

struct Drive {
  explicit Drive(rt::Executive& executive) {
    const rt::GroupId group = executive.add_group({"control", 2});
    imu = executive.add_stream<rt::ImuSample>(group, "IMU", 16, 8);
    tracks = executive.add_stream<rt::TrackSample>(group, "TRACK", 16, 8);
    executive.add_task<rt::AttitudeEstimate>(
        group, "attitude", 100, [this](rt::JobContext&, rt::AttitudeEstimate& output) {
          const rt::PoseEstimate& pose = odometry.estimate();
          if ((pose.flags & estimators::kPoseStarted) != 0) {
            attitude.set_moving(odometry.belts_run());
            if (odometry.velocity_known())
              static_cast<void>(attitude.set_track_velocity(rt::to_vector(pose.v_body_m_s), pose.stamp_ns));
          }
          // What is refused is counted by filter and odometry.
          for (const rt::ImuSample& sample : *imu) {
            if (attitude.update(sample) == Status::ok)
              static_cast<void>(odometry.observe(attitude.estimate()));
          }
          output = attitude.estimate();
        });
    executive.add_task<rt::PoseEstimate>(group, "odometry", 100,
                                         [this](rt::JobContext&, rt::PoseEstimate& output) {
                                           for (const rt::TrackSample& sample : *tracks)
                                             static_cast<void>(odometry.update(sample));
                                           output = odometry.estimate();
                                         });
  }
  void take(const bare::Record& record) {
    // A full stream counts its refusals.
    if (record.kind == bare::RecordKind::imu) static_cast<void>(imu->push(bare::to_imu(record)));
    if (record.kind == bare::RecordKind::track) static_cast<void>(tracks->push(bare::to_track(record)));
  }

  estimators::Attitude attitude{estimators::AttitudeConfig{}};
  estimators::TrackOdometry odometry{estimators::TrackOdometryConfig{}};
  rt::Stream<rt::ImuSample>* imu{};
  rt::Stream<rt::TrackSample>* tracks{};
};

}  // namespace

int main() { bare::run<Drive>(); }
