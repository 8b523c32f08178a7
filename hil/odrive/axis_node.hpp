// SPDX-License-Identifier: BSD-3-Clause
// A simulated axis of an ODrive: states, errors, watchdog, heartbeat and estimates on the CANSimple protocol.
// It obeys what it is sent and nothing else, boots late, trips where a real one does, and coasts when it is
// idle: docs/odrive.md has the table.
#pragma once

#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/odrive/axis.hpp"
#include "hil/drive_axis.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// What is set in the axis itself, where CANSimple does not reach, and how its firmware is.
struct AxisNodeConfig {
  std::uint8_t node = 1;
  rt::Nanoseconds heartbeat_ns = 50 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds estimates_ns = 10 * rt::kNanosecondsPerMillisecond;
  rt::Nanoseconds watchdog_ns = 100 * rt::kNanosecondsPerMillisecond;  ///< 0: off
  bool sends_current = true;
  bool absolute = false;  ///< encoder: turns do not begin with 0 at power-on
  rt::Nanoseconds boot_ns = 250 * rt::kNanosecondsPerMillisecond;  ///< power-on to the first frame
  std::uint32_t boot_error = 0;  ///< shown after boot until it is forgotten (0.6: initializing)
  rt::Nanoseconds enter_ns = 5 * rt::kNanosecondsPerMillisecond;  ///< idle to closed loop
  bool targets_alone_feed = false;  ///< the watchdog is fed by targets only (0.6), not by every frame (0.5)
  bool watched_when_idle = true;    ///< it also trips when idle (0.5)
  double overspeed = 1.2;           ///< share of its speed limit beyond which it trips; 0: never
  double bus_trip_turn_s2 = 0.0;    ///< deceleration that lifts the DC bus too high; 0: a resistor takes all
  double fastest_turn_s2 = 50.0;    ///< what its current limit makes of a step in speed
};

/// What the axis' motor is asked to do, and shows.
struct AxisMotorCommand {
  bool on{};  ///< under torque; otherwise it coasts
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
  std::uint64_t trips{};  ///< overspeed, DC bus
};

/// One axis. It sends by a port that it may share with others. No heap, one thread; copies are axes of their
/// own on the same port, set_port() gives them another.
class AxisNode {
 public:
  /// Errors, as the 0.5 firmwares number them.
  static constexpr std::uint32_t kInvalidState = 1;
  static constexpr std::uint32_t kBusVoltage = 2;
  static constexpr std::uint32_t kNotCalibrated = 0x10;
  static constexpr std::uint32_t kOverspeed = 0x200;
  static constexpr std::uint32_t kWatchdogExpired = 0x800;

  /// Throws std::runtime_error for a number above 63.
  AxisNode(const AxisNodeConfig& config, drivers::CanBus& port);

  // One moment: show(), hear() every frame that has come, step().
  void show(const AxisMotorState& motor) noexcept;
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void step(rt::Nanoseconds now_ns) noexcept;
  const AxisMotorCommand& command() const noexcept { return command_; }
  /// The same for an axis of the plant (hil/drive_axis.hpp), in turns.
  AxisWish wish() const noexcept;

  drivers::odrive::AxisState state() const noexcept { return state_; }
  std::uint32_t error() const noexcept { return error_; }
  double velocity_limit() const noexcept { return velocity_limit_; }
  double current_limit() const noexcept { return current_limit_; }
  const AxisNodeCounters& counters() const noexcept { return counters_; }
  /// When it last heard what feeds its watchdog; -1: never.
  rt::Nanoseconds fed_ns() const noexcept { return fed_ns_; }
  AxisNodeConfig& config() noexcept { return config_; }
  void set_port(drivers::CanBus& port) noexcept { port_ = &port; }

  // Faults to inject.
  void set_power(bool on) noexcept;                    ///< off: silent, forgets all; on: boots
  void set_mute(bool mute) noexcept { mute_ = mute; }  ///< hears, but sends nothing
  void set_deaf(bool deaf) noexcept { deaf_ = deaf; }  ///< sends, but hears nothing
  /// Every frame feeds its watchdog, and none is obeyed.
  void set_disobeys(bool on) noexcept { disobeys_ = on; }
  /// Closed loop is refused with an error, again and again.
  void set_calibrated(bool on) noexcept { calibrated_ = on; }
  /// Without: idle with an error that comes back as long as it lasts.
  void set_voltage(bool on) noexcept { voltage_ = on; }
  /// An error of the axis; the first `stubborn` attempts to forget it come too early.
  void fail(std::uint32_t error, int stubborn = 0) noexcept;
  /// Falls idle without an error.
  void leave() noexcept { enter(drivers::odrive::AxisState::idle); }

 private:
  void boot() noexcept;
  void ask(drivers::odrive::AxisState state, rt::Nanoseconds now_ns) noexcept;
  void enter(drivers::odrive::AxisState state) noexcept;
  void watch(rt::Nanoseconds now_ns) noexcept;
  void send(drivers::CanFrame frame) noexcept;
  void send_estimates() noexcept;

  AxisNodeConfig config_;
  drivers::CanBus* port_;
  AxisMotorCommand command_{};
  AxisMotorState motor_{};
  double estimate_turn_s_{};  // its own, filtered
  double origin_turns_{};     // where the motor was at power-on
  drivers::odrive::AxisState state_{drivers::odrive::AxisState::idle};
  std::uint32_t error_{};
  double velocity_limit_{2.0};
  double current_limit_{10.0};
  rt::Nanoseconds power_ns_{-1};
  rt::Nanoseconds fed_ns_{-1};
  rt::Nanoseconds closed_ns_{-1};  // when it will be in closed loop
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds next_estimates_ns_{};
  int stubborn_{};
  bool powered_{true};
  bool booted_{};
  bool mute_{};
  bool deaf_{};
  bool disobeys_{};
  bool calibrated_{true};
  bool voltage_{true};
  bool regenerates_too_much_{};
  AxisNodeCounters counters_{};
};

}  // namespace sortie::hil
