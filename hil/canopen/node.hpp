// SPDX-License-Identifier: BSD-3-Clause
// A simulated CANopen drive: object dictionary, network management, heartbeats both ways, mapped PDOs,
// emergencies and the state machine of CiA 402. It knows what is written into it and nothing else, takes its
// time for everything, and does what the standard lets a drive do: docs/canopen.md has the table.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/can_bus.hpp"
#include "drivers/canopen/cia402.hpp"
#include "drivers/canopen/frames.hpp"
#include "hil/canopen/dictionary.hpp"
#include "hil/drive_axis.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// Code of the emergency that a drive sends when it misses a heartbeat (CiA 301, life guard or heartbeat).
inline constexpr std::uint16_t kHeartbeatError = 0x8130;

/// What the drive's motor is asked to do, and shows.
struct MotorCommand {
  bool on{};  ///< torque: operation enabled, on a stopping ramp, or while its brake moves
  bool quick_stop{};
  bool brake_open{};        ///< of a drive with a brake
  std::int8_t mode{};       ///< of CiA 402: 3 velocity, 8 cyclic position
  std::int32_t velocity{};  ///< increments a second
  std::int32_t position{};  ///< increments
  std::int32_t ramp{};      ///< increments/s^2, of speeds
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
  std::uint64_t heartbeat_lost{};  ///< of the one that it consumes
  std::uint64_t boots{};
  std::uint64_t faults{};
};

/// How a drive is built; the standard allows all of it.
struct CanopenNodeConfig {
  rt::Nanoseconds boot_ns = 150 * rt::kNanosecondsPerMillisecond;      ///< power-on to boot-up
  rt::Nanoseconds sdo_ns = 3 * rt::kNanosecondsPerMillisecond;         ///< until an SDO is answered
  rt::Nanoseconds transition_ns = 4 * rt::kNanosecondsPerMillisecond;  ///< of each step towards torque
  rt::Nanoseconds brake_ns = 30 * rt::kNanosecondsPerMillisecond;  ///< until its brake has opened or closed
  rt::Nanoseconds sync_timeout_ns = 0;  ///< without SYNC for so long: a fault; 0: it does not watch
  bool brake = false;
  bool stopped_matters = true;  ///< network management "stop" is a lost connection (0x6007); some do not care
};

/// What keeps a drive from being enabled.
enum class EnableBlock : std::uint8_t {
  none,
  safe_torque_off,  ///< the safety input is open: no torque, and no step towards it
  no_voltage,       ///< its power stage has none
  brake,            ///< its brake does not open: it never gets past "switched on"
};

/// One drive. It sends by a port that it may share with others. No heap, one thread; copies are drives of
/// their own on the same port, set_port() gives them another.
class CanopenNode {
 public:
  /// Throws std::runtime_error for a number outside 1 to 127.
  CanopenNode(std::uint8_t node, drivers::CanBus& port, const CanopenNodeConfig& config = {});

  // One moment: show(), hear() every frame that has come, step().
  /// What the motor shows now; a standing motor ends a quick stop.
  void show(const MotorState& motor) noexcept;
  /// Takes a frame of the bus.
  void hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  /// Boots after power-on, takes its steps, watches master and motor, sends what is due.
  void step(rt::Nanoseconds now_ns) noexcept;
  const MotorCommand& command() const noexcept { return command_; }
  /// The same for an axis (hil/drive_axis.hpp) in increments.
  AxisWish wish() const noexcept;

  drivers::canopen::NmtState nmt() const noexcept { return nmt_; }
  drivers::canopen::DriveState state() const noexcept { return state_; }
  const CanopenNodeCounters& counters() const noexcept { return counters_; }
  CanopenDictionary& dictionary() noexcept { return objects_; }
  CanopenNodeConfig& config() noexcept { return config_; }
  void set_port(drivers::CanBus& port) noexcept { port_ = &port; }

  // Faults to inject.
  void set_power(bool on) noexcept;                    ///< off: silent, forgets all; on: boots
  void set_mute(bool mute) noexcept { mute_ = mute; }  ///< hears, but sends nothing
  void set_deaf(bool deaf) noexcept { deaf_ = deaf; }  ///< sends, but hears nothing
  /// Hears heartbeats and nothing else: filters that were set wrong.
  void set_hears_heartbeats_alone(bool on) noexcept { heartbeats_alone_ = on; }
  /// Heartbeats go on, readings do not: mute for those who count heartbeats alone.
  void set_no_readings(bool on) noexcept { no_readings_ = on; }
  void set_block(EnableBlock block) noexcept { block_ = block; }
  /// A fault of the drive, with its emergency; the first `stubborn` resets come too early. kForGood: until
  /// its power was off.
  void fail(std::uint16_t code, int stubborn = 0) noexcept;
  static constexpr int kForGood = 1'000'000'000;

 private:
  void boot(rt::Nanoseconds now_ns) noexcept;
  void reset() noexcept;
  void take(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept;
  void take_nmt(drivers::canopen::NmtCommand command, rt::Nanoseconds now_ns) noexcept;
  void take_sdo(const drivers::canopen::Sdo& request, rt::Nanoseconds now_ns) noexcept;
  void answer_sdo() noexcept;
  void take_rpdo(const drivers::CanFrame& frame) noexcept;
  void send_tpdo() noexcept;
  void watch_master(rt::Nanoseconds now_ns) noexcept;
  void watch_motor(rt::Nanoseconds now_ns) noexcept;
  void lose_connection() noexcept;
  void obey(std::uint16_t control) noexcept;
  void rise(drivers::canopen::DriveState state) noexcept;
  void take_steps(rt::Nanoseconds now_ns) noexcept;
  void enter(drivers::canopen::DriveState state) noexcept;
  void send(const drivers::CanFrame& frame) noexcept;
  void emergency(std::uint16_t code) noexcept;
  rt::Nanoseconds rise_time(drivers::canopen::DriveState to) const noexcept;

  drivers::CanBus* port_;
  CanopenNodeConfig config_;
  CanopenDictionary objects_;
  CanopenNodeCounters counters_{};
  MotorCommand command_{};
  MotorState motor_{};
  drivers::canopen::NmtState nmt_{drivers::canopen::NmtState::boot_up};
  drivers::canopen::DriveState state_{drivers::canopen::DriveState::switch_on_disabled};
  drivers::canopen::DriveState wanted_{drivers::canopen::DriveState::switch_on_disabled};  // being gone to
  drivers::canopen::Sdo request_{};
  std::uint16_t last_control_{};
  rt::Nanoseconds now_ns_{};
  rt::Nanoseconds power_ns_{-1};  // since when it has power; -1: not seen yet
  rt::Nanoseconds rise_ns_{};     // when the next state is reached
  rt::Nanoseconds sdo_due_ns_{};
  rt::Nanoseconds next_heartbeat_ns_{};
  rt::Nanoseconds master_heard_ns_{};
  rt::Nanoseconds sync_ns_{};
  rt::Nanoseconds rpdo_ns_{};
  rt::Nanoseconds follows_ns_{};  // when the motor last was where it should be
  bool master_known_{};           // heard since the consumer was set
  bool sdo_waits_{};
  EnableBlock block_{EnableBlock::none};
  int stubborn_{};
  bool powered_{true};
  bool booted_{};
  bool mute_{};
  bool deaf_{};
  bool heartbeats_alone_{};
  bool no_readings_{};
  std::uint8_t node_;
};

}  // namespace sortie::hil
