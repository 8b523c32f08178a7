// SPDX-License-Identifier: BSD-3-Clause
// The plain values that cross rooms. No Eigen, no LCM: arrays and scalars that any language could read.
// SI units, stamp first. Frames: world = z up, x at the start heading; body = x forward, y left, z up.
// Quaternions are w, x, y, z and rotate body vectors into the world: v_world = q_world_body * v_body.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// Bits of ImuSample::flags. A field whose bit is not set is not there: who reads a sample asks the bit
/// first, on every way that leads to the field, also before asking whether it is finite. The same holds for
/// the bits of every other sample.
enum ImuFlags : std::uint32_t {
  kImuGyr = 1u,        ///< gyr_rad_s is valid
  kImuAcc = 2u,        ///< acc_m_s2 is valid
  kImuMeanRate = 4u,   ///< values are means over the interval since the previous sample, not points in time
  kImuSaturated = 8u,  ///< the device reported a clipped axis
  kImuOnlyAccSaturated = 16u,  ///< beside kImuSaturated: the accelerometer's alone, the rates are whole
};

/// One reading of an inertial sensor, rotated into the body frame. acc is specific force (+9.81 z at rest).
struct ImuSample {
  Nanoseconds stamp_ns{};
  double gyr_rad_s[3]{};
  double acc_m_s2[3]{};
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, gyr_rad_s, acc_m_s2, flags)
};

/// Travel of the two tracks (or wheel sides) since start, positive forward: a lost sample loses nothing.
struct TrackSample {
  Nanoseconds stamp_ns{};
  double left_m{};
  double right_m{};
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, left_m, right_m, flags)
};

/// One return of a lidar in the sensor frame. 16 bytes.
struct ScanPoint {
  float x_m{};
  float y_m{};
  float z_m{};
  std::uint16_t intensity{};
  std::uint16_t age_10us{};  ///< time before the scan's stamp, in steps of 10 us
  SORTIE_FIELDS(x_m, y_m, z_m, intensity, age_10us)
};

/// Bits of ScanHeader::flags.
enum ScanFlags : std::uint32_t {
  kScanPosed = 1u,  ///< p_world_sensor_m and q_world_sensor are given; otherwise the odometry poses it
};

/// What travels with a scan; the points lie in a pooled buffer.
struct ScanHeader {
  Nanoseconds stamp_ns{};
  std::uint32_t points{};
  std::uint32_t flags{};
  double p_world_sensor_m[3]{};
  double q_world_sensor[4]{1, 0, 0, 0};
  SORTIE_FIELDS(stamp_ns, points, flags, p_world_sensor_m, q_world_sensor)
};

/// A scan as an algorithm sees it. The points belong to someone else and live for one call.
struct PointScan {
  ScanHeader header;
  const ScanPoint* points{};  ///< header.points of them
};

/// Attitude and gyro bias as the attitude filter gives them.
struct AttitudeEstimate {
  Nanoseconds stamp_ns{};
  double q_world_body[4]{1, 0, 0, 0};
  double w_body_rad_s[3]{};  ///< bias removed
  double bias_rad_s[3]{};
  double delta_heading_rad{};  ///< turn about the world's up axis since start, not wrapped
  std::uint32_t rejected{};    ///< samples refused so far
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, q_world_body, w_body_rad_s, bias_rad_s, delta_heading_rad, rejected, flags)
};

/// Pose and twist of the body, 6x6 covariance of (position in world, rotation in body) by rows [m^2, rad^2].
struct PoseEstimate {
  Nanoseconds stamp_ns{};
  double p_world_body_m[3]{};
  double q_world_body[4]{1, 0, 0, 0};
  double v_body_m_s[3]{};
  double w_body_rad_s[3]{};
  double covariance[36]{};
  double distance_m{};       ///< path length so far
  std::uint32_t rejected{};  ///< samples refused so far
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, p_world_body_m, q_world_body, v_body_m_s, w_body_rad_s, covariance, distance_m,
                rejected, flags)
};

/// Bits of DriveCommand::flags and, the first, of FlipperCommand::flags.
enum CommandFlags : std::uint32_t {
  kCommandEnabled = 1u,      ///< the motors shall follow
  kCommandWanted = 128u,     ///< somebody wants motion, also while the robot is made to wait: torque stays on
  kCommandEmergency = 256u,  ///< as an emergency stop that is pressed
};

/// What the drives are asked to do.
struct DriveCommand {
  Nanoseconds stamp_ns{};
  double left_m_s{};
  double right_m_s{};
  std::uint32_t waypoint{};  ///< number of the waypoint driven to
  std::uint32_t flags{};     ///< bits of CommandFlags
  /// How often somebody has asked for motion. Motors that were stopped start when it has risen since, and by
  /// nothing else: that a speed is wanted again, or enabled again, is no request.
  std::uint32_t asked{};
  SORTIE_FIELDS(stamp_ns, left_m_s, right_m_s, waypoint, flags, asked)
};
/// A command to stand, or to leave the drives to their brakes (rt/command_outlet.hpp).
constexpr bool stops(const DriveCommand& command) {
  return (command.flags & kCommandEnabled) == 0 || (command.flags & kCommandEmergency) != 0 ||
         (command.left_m_s == 0.0 && command.right_m_s == 0.0);
}

/// Values of DriveRequest::mode.
enum class DriveMode : std::uint32_t {
  drive,          ///< speed and turn rate, and from now on whoever asks is in control
  release,        ///< hands control back to the mission; also ends a halt
  halt,           ///< stops and stays, until a release
  emergency,      ///< as an emergency stop that is pressed: no torque, until emergency_end
  emergency_end,  ///< as its release: from then on it is a halt
  go,  ///< to a place, by a way of its own; ends no halt, and hands back what was in control outside
};

/// Bits of DriveRequest::flags.
enum DriveRequestFlags : std::uint32_t {
  kDriveThoughTilted = 1u,  ///< drive slowly although the robot is tilted, to get it off
  /// Who asks knows of what stopped the motors, and asks anew. It counts where the request before had it not:
  /// a stream that always has it asks once.
  kDriveAnew = 2u,
};

/// What somebody outside asks the drive to do.
struct DriveRequest {
  Nanoseconds stamp_ns{};  ///< receipt on the run's clock; 0 before
  std::int64_t counter{};  ///< of the sender: above all that were taken
  double speed_m_s{};
  double turn_rad_s{};  ///< positive to the left
  std::uint32_t mode{};
  std::int32_t posture{-1};  ///< of the flippers, by number; -1: as they are
  std::uint32_t flags{};
  double goal_x_m{};  ///< of `go`, in the world of the pose
  double goal_y_m{};
  SORTIE_FIELDS(stamp_ns, counter, speed_m_s, turn_rad_s, mode, posture, flags, goal_x_m, goal_y_m)
};

/// The flippers in the order of every array about them.
enum Flipper : std::uint32_t { kFrontLeft, kFrontRight, kRearLeft, kRearRight };
inline constexpr std::uint32_t kFlippers = 4;

/// What the flippers are asked to do. Angles of the flippers to the body: 0 stretched out in the plane of the
/// tracks, positive with the tip up, for the front and the rear ones alike.
struct FlipperCommand {
  Nanoseconds stamp_ns{};
  double angle_rad[kFlippers]{};
  std::uint32_t flags{};  ///< bit 0: enabled
  std::uint32_t asked{};  ///< as DriveCommand's
  SORTIE_FIELDS(stamp_ns, angle_rad, flags, asked)
};
/// A command that leaves the flippers to their brakes (rt/command_outlet.hpp).
constexpr bool stops(const FlipperCommand& command) { return (command.flags & 1u) == 0; }

/// Where the flippers are, and what turns them. Angles as in FlipperCommand; torques > 0 turn the tip up.
struct FlipperSample {
  Nanoseconds stamp_ns{};
  double angle_rad[kFlippers]{};
  double torque_n_m[kFlippers]{};
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, angle_rad, torque_n_m, flags)
};

/// Bits of TruthSample::flags.
enum TruthFlags : std::uint32_t {
  kTruthPosition = 1u,
  kTruthHeight = 2u,  ///< the z of the position is meant, too (GPS altitude is not)
  kTruthOrientation = 4u,
  kTruthMoving = 8u,  ///< errors count only while this is set (if any sample of the log has it)
};

/// Reference pose for judging a run. Never an input of any task.
struct TruthSample {
  Nanoseconds stamp_ns{};
  double p_world_body_m[3]{};
  double q_world_body[4]{1, 0, 0, 0};
  std::uint32_t flags{};
  SORTIE_FIELDS(stamp_ns, p_world_body_m, q_world_body, flags)
};

}  // namespace sortie::rt
