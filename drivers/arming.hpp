// SPDX-License-Identifier: BSD-3-Clause
// The one owner of "may the motors run": for all motors of a robot together, whatever bus they are on.
#pragma once

#include <cstdint>

#include "rt/time.hpp"

namespace sortie::drivers {

/// Why the drives do not run; the first of these that holds.
enum class StopReason : std::uint8_t {
  none,
  disarmed,         ///< nobody asks for them
  command_stale,    ///< the targets are too old
  drive_lost,       ///< a drive's heartbeat is missing, or it restarted
  drive_fault,      ///< a drive reports a fault
  drive_emergency,  ///< a drive has sent an emergency
  drive_left,       ///< a drive stopped by itself
  bus_refuses,      ///< frames cannot be sent
  not_ready,        ///< asked for, but a drive is not set up yet
};

const char* to_string(StopReason reason);

/// When a run ends, and when another may begin.
struct ArmingConfig {
  rt::Nanoseconds command_timeout_ns = 200 * rt::kNanosecondsPerMillisecond;
  /// After a stop the drives run again when all have been healthy for so long, if they are still asked for;
  /// 0: only when they are asked anew.
  rt::Nanoseconds rearm_ns = 0;
};

/// All drives run, or none does. Plain; one thread; a few instructions a call.
class Arming {
 public:
  /// What a call of decide() changed.
  enum class Change : std::uint8_t { nothing, began, ended, stopped };  // ended: because nobody asks

  explicit Arming(const ArmingConfig& config) : config_(config) {}

  /// Whether the drives may run; renewed with every command.
  void set(bool armed, rt::Nanoseconds now_ns) noexcept;
  /// The emergency stop: until released, nothing runs.
  void press(bool pressed) noexcept { pressed_ = pressed; }
  /// Once a cycle. `drives`: why these cannot run, as far as they know; `healthy`: all are ready and without
  /// fault.
  Change decide(StopReason drives, bool healthy, rt::Nanoseconds now_ns) noexcept;

  bool running() const noexcept { return running_; }
  StopReason reason() const noexcept { return reason_; }
  /// When the run began.
  rt::Nanoseconds run_ns() const noexcept { return run_ns_; }

 private:
  ArmingConfig config_;
  bool armed_{};
  bool asked_{};  // armed has been false since the last stop
  bool pressed_{};
  bool running_{};
  StopReason reason_{StopReason::disarmed};
  rt::Nanoseconds set_ns_{};
  rt::Nanoseconds run_ns_{};
  rt::Nanoseconds ill_ns_{};  // when last not all drives were healthy
};

}  // namespace sortie::drivers
