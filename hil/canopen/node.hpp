// SPDX-License-Identifier: BSD-3-Clause
// A simulated CANopen drive: object dictionary, network management, heartbeats both ways, mapped PDOs,
// emergencies and the state machine of CiA 402. It knows what is written into it and nothing else: a master
// that forgets a step gets what a real drive would give.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/canopen/cia402.hpp"
#include "drivers/canopen/frames.hpp"
#include "hil/canopen/dictionary.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// What the drive's motor is asked to do, and shows.
struct MotorCommand {
  bool on{};  ///< operation enabled, or on its quick-stop ramp
  bool quick_stop{};
  std::int8_t mode{};       ///< of CiA 402: 3 velocity, 8 cyclic position
  std::int32_t velocity{};  ///< increments a second
  std::int32_t position{};  ///< increments
};
struct MotorState {
  std::int32_t position{};
  std::int32_t velocity{};
  std::int16_t torque{};  ///< per mille
};

/// Counts since construction.
struct CanopenNodeCounters {
  std::uint64_t received{};
  std::uint64_t sent{};
  std::uint64_t refused{};         ///< frames that the port did not take
  std::uint64_t heartbeat_lost{};  ///< the master's
  std::uint64_t boots{};
};

/// One drive. It sends by a port that it may share with others. No heap, one thread.
class CanopenNode {
 public:
  /// Throws std::runtime_error for a number outside 1 to 127.
  CanopenNode(std::uint8_t node, drivers::CanBus& port);

  // One moment: show(), hear() every frame that has come, step().
  /// What the motor shows now; a standing motor ends a quick stop.
  void show(const MotorState& motor) noexcept;
  /// Takes a frame of the bus.
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// Boots after power-on, watches the master, sends the heartbeat.
  void step(rt::Nanoseconds now_ns) noexcept;
  const MotorCommand& command() const noexcept { return command_; }

  drivers::canopen::NmtState nmt() const noexcept { return nmt_; }
  drivers::canopen::DriveState state() const noexcept { return state_; }
  const CanopenNodeCounters& counters() const noexcept { return counters_; }
  CanopenDictionary& dictionary() noexcept { return objects_; }

  // Faults to inject.
  void set_power(bool on) noexcept;                    ///< off: silent, forgets all; on: boots
  void set_mute(bool mute) noexcept { mute_ = mute; }  ///< hears, but sends nothing
  /// A fault of the drive, with its emergency; the first `stubborn` resets come too early.
  void fail(std::uint16_t code, int stubborn = 0) noexcept;

 private:
  void boot() noexcept;
  void take(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void take_nmt(drivers::canopen::NmtCommand command) noexcept;
  void take_sdo(const drivers::canopen::Sdo& request) noexcept;
  void take_rpdo(const drivers::CanFrame& frame) noexcept;
  void send_tpdo() noexcept;
  void watch_master(rt::Nanoseconds now_ns) noexcept;
  void obey(std::uint16_t control) noexcept;
  void enter(drivers::canopen::DriveState state) noexcept;
  void send(const drivers::CanFrame& frame) noexcept;
  void emergency(std::uint16_t code) noexcept;

  drivers::CanBus* port_;
  CanopenDictionary objects_;
  CanopenNodeCounters counters_{};
  MotorCommand command_{};
  drivers::canopen::NmtState nmt_{drivers::canopen::NmtState::boot_up};
  drivers::canopen::DriveState state_{drivers::canopen::DriveState::switch_on_disabled};
  std::uint16_t last_control_{};
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds master_heard_ns_{};
  bool master_known_{};  // heard since the consumer was set
  int stubborn_{};
  bool powered_{true};
  bool booted_{};
  bool mute_{};
  std::uint8_t node_;
};

}  // namespace sortie::hil
