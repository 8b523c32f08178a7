// SPDX-License-Identifier: BSD-3-Clause
// What is written into a drive's object dictionary before it may run, step by step, and how each is judged.
#pragma once

#include <cstdint>

#include "drivers/canopen/cia402.hpp"
#include "drivers/canopen/frames.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/time.hpp"

namespace sortie::drivers::canopen {

/// One drive and how it is watched.
struct DriveConfig {
  std::uint8_t node = 1;      ///< 1 to 127
  std::uint8_t master = 127;  ///< our number, whose heartbeat the drive waits for
  DriveKind kind = DriveKind::velocity;
  rt::Nanoseconds sync_period_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;  ///< of the drive, and of ours
  /// Silence after which the drive stops by itself, and after which we call the drive lost.
  rt::Nanoseconds heartbeat_timeout_ns = 150 * rt::kNanosecondsPerMillisecond;
  /// Readings older than this are no readings: the drive is lost, whatever its heartbeat says.
  rt::Nanoseconds reading_timeout_ns = 60 * rt::kNanosecondsPerMillisecond;
  /// Deceleration of a quick stop, increments/s^2.
  std::uint32_t quick_stop_s2 = 60'000;
};

/// What a step does.
enum class SetupKind : std::uint8_t {
  expect,  ///< read; the low 16 bits must be `value`
  write,
  verify,  ///< read back; must be `value`
  settle,  ///< read the status again and again until it shows no torque
};

/// One step.
struct SetupStep {
  SetupKind kind{};
  ObjectKey key{};
  std::uint32_t value{};
  std::uint8_t bytes{};
};

/// The steps of one drive: device type, how it stops and that it has stopped (pre-operational stops no drive,
/// and who was here before may have left it enabled), heartbeats both ways (the consumer's read back, since
/// the robot's safe stop hangs on it), what a lost connection does (a quick stop), the mode, and the first
/// PDO of each direction with mappings of our own. 42 steps at most.
class DriveSetup : public rt::FixedVector<SetupStep, 42> {
 public:
  explicit DriveSetup(const DriveConfig& config);

 private:
  void add(SetupKind kind, std::uint16_t index, std::uint8_t sub, std::uint32_t value, std::uint8_t bytes);
  void map(std::uint16_t communication, std::uint16_t mapping, std::uint32_t cob_id, std::uint32_t flags,
           std::uint8_t transmission, const std::uint32_t* entries, std::uint8_t count);
};

/// Transmission type of a PDO: applied or sent at once, or with every SYNC.
inline constexpr std::uint8_t kPdoAtOnce = 255;
inline constexpr std::uint8_t kPdoEverySync = 1;
/// Bit of a PDO's identifier: it does not exist.
inline constexpr std::uint32_t kPdoOff = 0x8000'0000;
/// Bit of a PDO's identifier: it is not sent on remote request.
inline constexpr std::uint32_t kPdoNoRemote = 0x4000'0000;
/// Device profile of a drive, in the low half of object 0x1000.
inline constexpr std::uint16_t kDriveProfile = 402;
/// Value of kQuickStopOption: on the quick-stop ramp, then without torque.
inline constexpr std::uint16_t kQuickStopRamp = 2;
/// Value of kAbortOption: a lost connection is answered by a quick stop.
inline constexpr std::uint16_t kAbortQuickStop = 3;

}  // namespace sortie::drivers::canopen
