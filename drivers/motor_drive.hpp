// SPDX-License-Identifier: BSD-3-Clause
// One drive as the group of all drives sees it, whatever bus it is on, and why a group stops.
#pragma once

#include <cstdint>

#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::drivers {

/// Why the drives do not run; the first of these that holds. Numbers are part of the log: new ones come last.
enum class StopReason : std::uint8_t {
  none,
  disarmed,         ///< nobody asks for them
  command_stale,    ///< a source that asked for them has fallen silent
  drive_lost,       ///< a drive is silent, its readings are old, or it restarted
  drive_fault,      ///< a drive reports a fault
  drive_emergency,  ///< a drive has sent an emergency
  drive_left,       ///< a drive stopped by itself
  bus_refuses,      ///< frames cannot be sent
  not_ready,        ///< asked for, but a drive is not set up yet
  emergency_stop,   ///< an emergency stop is pressed, or was since they were asked last
  start_failed,     ///< not all drives came up in time
};

const char* to_string(StopReason reason);

/// What a drive is told.
enum class DriveOrder : std::uint8_t {
  rest,  ///< no torque
  hold,  ///< torque, and no motion: speed 0, or where it stood when it came under torque or was told to hold
  follow,  ///< torque, and a target
  stop,    ///< to rest on the steepest ramp, then no torque
};

/// One drive. The group asks what it is, and tells it one thing in every cycle; what is told holds until the
/// next. No call waits, throws or takes memory.
class MotorDrive {
 public:
  virtual ~MotorDrive() = default;

  /// Found, set up, heard and read of late: it may be asked to run. A fault that a start would forget is no
  /// hindrance.
  virtual bool ready(rt::Nanoseconds now_ns) const noexcept = 0;
  /// Under torque, without fault, and obeying.
  virtual bool running(rt::Nanoseconds now_ns) const noexcept = 0;
  /// It says of itself that it has no torque. What is not heard of is not free.
  virtual bool free(rt::Nanoseconds now_ns) const noexcept = 0;
  /// Since begin(): why it cannot run any more; none while it comes up, and while it runs. What was wrong
  /// before is no trouble, what goes wrong on the way is.
  virtual StopReason trouble(rt::Nanoseconds now_ns) const noexcept = 0;

  /// A start is asked for: what happened before does not count any more, and faults may be forgotten.
  virtual void begin() noexcept = 0;
  /// `target`: to follow, in the drive's own unit, or a second.
  virtual void tell(DriveOrder order, double target) noexcept = 0;
};

}  // namespace sortie::drivers
