// SPDX-License-Identifier: BSD-3-Clause
// The ground robot: IMU, tracks, flippers, lidar and requests in; attitude, odometry, map, and commands to
// drives and flippers out.
#pragma once

#include <atomic>
#include <memory>
#include <optional>

#include "drivers/can_codec.hpp"
#include "drivers/ugv_motors.hpp"
#include "estimators/track_odometry.hpp"
#include "firmware_like/parts/chosen_attitude.hpp"
#include "firmware_like/parts/emergency_inputs.hpp"
#include "firmware_like/parts/own_motors.hpp"
#include "firmware_like/parts/ugv_map.hpp"
#include "firmware_like/parts/ugv_ssl.hpp"
#include "firmware_like/runtime/owned_part.hpp"
#include "firmware_like/runtime/vehicle.hpp"
#include "planner/flipper_postures.hpp"
#include "planner/ugv_drive.hpp"

namespace sortie::firmware {

/// Group `control`: attitude -> odometry -> drive -> flippers, hop-free; group `mapping`: map ->
/// occupancy -> ssl. Each part is left out with [tasks.NAME] enabled = false, and then has no memory.
class Ugv final : public Vehicle, public UnitTryer {
 public:
  explicit Ugv(VehicleBuilder& builder);

  void open_devices() override;
  std::optional<MotorsNews> motors_news() const override;
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;
  drivers::ScanSink* scan_sink() override {
    return rt::kBuilt<rt::Part::map> && map_ ? map_->port() : nullptr;
  }
  ReportQueue<rt::SegmentList>* segment_lists() override {
    return rt::kBuilt<rt::Part::map> && map_ ? map_->segment_lists() : nullptr;
  }
  UnitTrial try_units() const override {
    return rt::kBuilt<rt::Part::ssl> && ssl_ ? ssl_->try_units() : UnitTrial{};
  }
  RequestEntry<rt::DriveRequest> drive_requests() override { return {request_port_, request_rules_}; }
  const rt::Task<rt::PoseEstimate>* pose_task() const override { return odometry_task_; }
  const rt::Task<rt::AttitudeEstimate>* attitude_task() const override { return attitude_task_; }
  std::optional<mapping::OccupancyView> occupancy() const override {
    return rt::kBuilt<rt::Part::ssl> && ssl_ ? ssl_->occupancy() : std::nullopt;
  }
  void for_each_voxel(const std::function<void(const VoxelOnMap&)>& put) const override;

 private:
  static constexpr std::uint32_t kImuBatch = 64;

  void add_attitude(VehicleBuilder& builder, rt::GroupId group);
  void add_odometry(VehicleBuilder& builder, rt::GroupId group);
  void add_odometry_counters(VehicleBuilder& builder);
  void add_odometry_state(VehicleBuilder& builder, rt::GroupId group);
  void listen_to_flippers(VehicleBuilder& builder, rt::GroupId group);
  void run_odometry();
  void add_drive(VehicleBuilder& builder, rt::GroupId group);
  void add_drive_counters(VehicleBuilder& builder);
  void add_flippers(VehicleBuilder& builder, rt::GroupId group);
  void add_motors(VehicleBuilder& builder);
  void add_bus_frames(VehicleBuilder& builder);
  void send_commands(drivers::CanBus& can, rt::Nanoseconds now_ns);
  void send_to_motors(drivers::CanBus& can, const rt::DriveCommand* command,
                      const rt::FlipperCommand* flippers, rt::Nanoseconds now_ns);
  void add_pose_input(VehicleBuilder& builder, rt::GroupId group);
  void add_ssl(VehicleBuilder& builder, rt::GroupId group);
  void take_frame(const drivers::CanFrame& frame, const Devices& devices, rt::Nanoseconds now_ns);

  // Inputs.
  rt::Stream<rt::ImuSample>* imu_{};
  rt::Stream<rt::TrackSample>* tracks_{};
  rt::Stream<rt::DriveRequest>* requests_{};
  rt::Stream<rt::FlipperSample>* flipper_states_{};
  InputPort<rt::ImuSample>* imu_port_{};
  InputPort<rt::TrackSample>* track_port_{};
  InputPort<rt::DriveRequest>* request_port_{};
  InputPort<rt::FlipperSample>* flipper_port_{};
  // Algorithms; null where the scene leaves them out.
  std::unique_ptr<ChosenAttitude> attitude_;
  std::unique_ptr<estimators::TrackOdometry> odometry_;
  std::unique_ptr<planner::UgvDrive> drive_;
  std::unique_ptr<planner::FlipperPostures> flippers_;
  OwnedPart<UgvMap, rt::Part::map> map_;
  OwnedPart<UgvSsl, rt::Part::ssl> ssl_;
  // Tasks and what crosses groups.
  rt::Task<rt::AttitudeEstimate>* attitude_task_{};
  rt::Task<rt::PoseEstimate>* odometry_task_{};
  rt::Task<planner::FlipperOutput>* flipper_task_{};
  rt::Input<rt::PoseEstimate>* pose_input_{};  // of the group `mapping`; null without odometry
  rt::CommandOutlet<rt::DriveCommand>* drive_outlet_{};
  rt::CommandOutlet<rt::FlipperCommand>* flipper_outlet_{};
  planner::RequestRules request_rules_;
  // Every attitude of the present job, for the odometry that runs behind it.
  rt::AttitudeEstimate job_attitudes_[kImuBatch]{};
  const rt::ImuSample* job_samples_[kImuBatch]{};  // that led to them
  std::uint32_t job_attitude_count_{};
  // Devices.
  drivers::CanSampleDecoder decoder_;
  std::unique_ptr<drivers::UgvMotors> motors_;  ///< null: they speak the robot's own frames
  OwnMotors own_motors_;
  EmergencyInputs emergency_;
  bool emergency_asked_{};                    // by the newest command
  std::atomic<std::uint32_t> motors_news_{};  // MotorsNews in one word, so that it is read whole
  rt::Nanoseconds device_epoch_ns_{};
  std::uint32_t imu_kind_{};
  bool track_aid_{};
  bool obstacles_{};                    // the odometry knows obstacles
  bool obstacle_flippers_{};            // and is told the flippers' angles
  OwnMotors::Counters drive_commands_;  // that motors of another protocol took, or refused
  OwnMotors::Counters flipper_commands_;
};

}  // namespace sortie::firmware
