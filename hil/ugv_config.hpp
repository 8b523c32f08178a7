// SPDX-License-Identifier: BSD-3-Clause
// All settings of the simulated ground vehicle in one place.
#pragma once

#include <cstdint>

#include "drivers/can_codec.hpp"
#include "hil/canopen/vehicle_drives.hpp"
#include "hil/encoder_model.hpp"
#include "hil/fault_injection.hpp"
#include "hil/hall.hpp"
#include "hil/imu_model.hpp"
#include "hil/kinematic_robot.hpp"
#include "hil/lidar_model.hpp"
#include "hil/odrive/vehicle_axes.hpp"
#include "hil/plant/course.hpp"
#include "hil/plant/tracked_body.hpp"
#include "hil/rolling_laser.hpp"
#include "hil/ssl_sensor.hpp"
#include "hil/stop_script.hpp"

namespace sortie::hil {

/// The lidar that a vehicle has.
enum class LidarKind : std::uint8_t {
  rows,         ///< `lidar`
  rotating_2d,  ///< `rolling_laser`
};

/// The vehicle, its hall, its sensors and their faults. The defaults are a mission in a 20 x 14 m hall.
struct UgvConfig {
  std::uint64_t seed{1};        ///< of all sensors and faults (the furniture has its own: hall.seed)
  rt::Nanoseconds start_ns{0};  ///< plant time before the first step
  HallConfig hall{};
  RobotConfig robot{};
  bool contacts{};  ///< the body is the tracked plant on `course`, not the robot without forces in `hall`
  CourseConfig course{};  ///< with contacts alone
  TrackedBodyConfig tracked{};
  ImuConfig imu{};
  EncoderConfig encoder{};
  VehicleDrivesConfig drives{};  ///< enabled: commands, travel and flippers go by CANopen alone
  VehicleAxesConfig axes{};      ///< the same for ODrives; one of them at most
  LidarKind lidar_kind{LidarKind::rows};
  LidarConfig lidar{};
  RollingLaserConfig rolling_laser{};
  SslConfig ssl{};
  bool self_hits{};               ///< the range sensors see the robot itself
  std::vector<StopDeed> stops{};  ///< in order of time; not empty: there is an emergency stop's button
  FaultConfig imu_faults{};
  FaultConfig track_faults{};
  FaultConfig lidar_faults{};     ///< only drop and time jump mean something
  FaultConfig ssl_faults{};       ///< the same
  FaultConfig command_faults{};   ///< only drop: the drives do not hear a command
  drivers::CanCodecConfig can{};  ///< epoch of the devices' time counters; the decoder needs the same
};

}  // namespace sortie::hil
