// SPDX-License-Identifier: BSD-3-Clause
// The route is driven: drive, flippers and motors, as a part of the ground robot.
#pragma once

#include <atomic>

#include "drivers/ugv_drives.hpp"
#include "firmware_like/parts/emergency_inputs.hpp"
#include "firmware_like/parts/odometry_part.hpp"
#include "firmware_like/parts/own_motors.hpp"
#include "planner/flipper_postures.hpp"
#include "planner/ugv_drive.hpp"

namespace sortie::firmware {

/// Group `control`, behind the odometry: tasks `drive` and, where the robot has them, `flippers`. On the I/O
/// thread: their commands to the motors, whatever protocol those speak, and the emergency stop.
class DrivePart final : public Part {
 public:
  explicit DrivePart(VehicleBuilder& builder);

  void finish(VehicleBuilder& builder) override;
  void open_devices() override { emergency_.open(); }
  bool take_frame(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) override;
  void heard(const drivers::CanSample& sample, rt::Nanoseconds now_ns) override;
  void poll_devices(const Devices& devices, rt::Nanoseconds now_ns) override;
  std::optional<MotorsNews> motors_news() const override;
  RequestEntry<rt::DriveRequest> drive_requests() override { return {request_port_, request_rules_}; }

 private:
  void add_task(VehicleBuilder& builder);
  void add_counters(VehicleBuilder& builder);
  void add_flippers(VehicleBuilder& builder);
  void add_motors(VehicleBuilder& builder);
  void send_to_motors(drivers::CanBus& can, const rt::DriveCommand* command,
                      const rt::FlipperCommand* flippers, rt::Nanoseconds now_ns);

  const OdometryPart& odometry_;
  rt::GroupId group_;
  rt::Stream<rt::DriveRequest>* requests_{};
  InputPort<rt::DriveRequest>* request_port_{};
  planner::RequestRules request_rules_;
  std::unique_ptr<planner::UgvDrive> drive_;
  rt::CommandOutlet<rt::DriveCommand>* drive_outlet_{};
  // Null where the scene has no flippers.
  std::unique_ptr<planner::FlipperPostures> flippers_;
  rt::Stream<rt::FlipperSample>* flipper_states_{};
  rt::CommandOutlet<rt::FlipperCommand>* flipper_outlet_{};
  // The I/O thread's.
  std::unique_ptr<drivers::UgvDrives> motors_;  ///< null: they speak the robot's own frames
  OwnMotors own_motors_;
  EmergencyInputs emergency_;
  bool emergency_asked_{};                    // by the newest command
  std::atomic<std::uint32_t> motors_news_{};  // MotorsNews in one word, so that it is read whole
  OwnMotors::Counters drive_commands_;        // that motors of another protocol took, or refused
  OwnMotors::Counters flipper_commands_;
  InputPort<rt::TrackSample>* track_port_{};
  InputPort<rt::FlipperSample>* flipper_port_{};
};

}  // namespace sortie::firmware
