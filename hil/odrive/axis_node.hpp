// SPDX-License-Identifier: BSD-3-Clause
// A simulated axis of an ODrive: states, errors, watchdog, heartbeat and estimates on the CANSimple protocol.
// It obeys what it is sent and nothing else.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/odrive/axis.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// What is set in the axis itself, where CANSimple does not reach.
struct AxisNodeConfig {
  std::uint8_t node = 1;
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds estimates_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds watchdog_ns = 100 * rt::kNanosecondsPerMillisecond;  ///< 0: off
  bool sends_current = true;
  bool absolute = false;  ///< encoder: turns do not begin with 0 at power-on
};

/// What the axis' motor is asked to do, and shows.
struct AxisMotorCommand {
  bool on{};  ///< under torque
  bool by_position{};
  double turns{};
  double turns_s{};
};
struct AxisMotorState {
  double turns{};
  double turns_s{};
  double current_a{};
};

/// Counts since construction.
struct AxisNodeCounters {
  std::uint64_t received{};
  std::uint64_t sent{};
  std::uint64_t refused{};  ///< frames that the port did not take
  std::uint64_t watchdog{};
  std::uint64_t boots{};
};

/// One axis. It sends by a port that it may share with others. No heap, one thread.
class AxisNode {
 public:
  /// Errors, as the 0.5 firmwares number them.
  static constexpr std::uint32_t kInvalidState = 1;
  static constexpr std::uint32_t kWatchdogExpired = 0x800;

  /// Throws std::runtime_error for a number above 63.
  AxisNode(const AxisNodeConfig& config, drivers::CanBus& port);

  // One moment: show(), hear() every frame that has come, step().
  void show(const AxisMotorState& motor) noexcept { motor_ = motor; }
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void step(rt::Nanoseconds now_ns) noexcept;
  const AxisMotorCommand& command() const noexcept { return command_; }

  drivers::odrive::AxisState state() const noexcept { return state_; }
  std::uint32_t error() const noexcept { return error_; }
  double velocity_limit() const noexcept { return velocity_limit_; }
  double current_limit() const noexcept { return current_limit_; }
  const AxisNodeCounters& counters() const noexcept { return counters_; }

  // Faults to inject.
  void set_power(bool on) noexcept;                    ///< off: silent, forgets all; on: boots
  void set_mute(bool mute) noexcept { mute_ = mute; }  ///< hears, but sends nothing
  void set_deaf(bool deaf) noexcept { deaf_ = deaf; }  ///< sends, but hears nothing
  /// An error of the axis; the first `stubborn` attempts to forget it come too early.
  void fail(std::uint32_t error, int stubborn = 0) noexcept;
  /// Falls idle without an error.
  void leave() noexcept { enter(drivers::odrive::AxisState::idle); }

 private:
  void boot() noexcept;
  void enter(drivers::odrive::AxisState state) noexcept;
  void send(drivers::CanFrame frame) noexcept;
  void send_estimates() noexcept;

  AxisNodeConfig config_;
  drivers::CanBus* port_;
  AxisMotorCommand command_{};
  AxisMotorState motor_{};
  double origin_turns_{};  // where the motor was at power-on
  drivers::odrive::AxisState state_{drivers::odrive::AxisState::idle};
  std::uint32_t error_{};
  double velocity_limit_{2.0};
  double current_limit_{10.0};
  rt::Nanoseconds fed_ns_{-1};
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds next_estimates_ns_{};
  int stubborn_{};
  bool powered_{true};
  bool booted_{};
  bool mute_{};
  bool deaf_{};
  AxisNodeCounters counters_{};
};

}  // namespace sortie::hil
