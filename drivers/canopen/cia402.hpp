// SPDX-License-Identifier: BSD-3-Clause
// The state machine of a drive (CiA 402, IEC 61800-7-201): what a status word says, and which control word
// leads on.
#pragma once

#include <cstdint>

namespace sortie::drivers::canopen {

/// Objects of a drive.
inline constexpr std::uint16_t kControlWord = 0x6040;
inline constexpr std::uint16_t kStatusWord = 0x6041;
inline constexpr std::uint16_t kAbortOption = 0x6007;
inline constexpr std::uint16_t kQuickStopOption = 0x605A;
inline constexpr std::uint16_t kModeWanted = 0x6060;
inline constexpr std::uint16_t kModeShown = 0x6061;
inline constexpr std::uint16_t kPositionActual = 0x6064;
inline constexpr std::uint16_t kVelocityActual = 0x606C;
inline constexpr std::uint16_t kTorqueActual = 0x6077;
inline constexpr std::uint16_t kTargetPosition = 0x607A;
inline constexpr std::uint16_t kQuickStopRate = 0x6085;
inline constexpr std::uint16_t kTargetVelocity = 0x60FF;

/// Values of kModeWanted that are used here.
enum class DriveKind : std::uint8_t {
  velocity = 3,         ///< profile velocity: a track
  cyclic_position = 8,  ///< cyclic synchronous position: a flipper
};

/// Where a drive stands.
enum class DriveState : std::uint8_t {
  not_ready,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop,
  fault_reaction,
  fault,
  unknown,  ///< bits that no state has
};

/// What is wanted of it.
enum class DriveWish : std::uint8_t {
  rest,        ///< no torque: disabled
  run,         ///< operation enabled
  quick_stop,  ///< stop on the steepest ramp, then no torque
};

/// State by the status word's bits 0 to 3, 5 and 6.
constexpr DriveState drive_state(std::uint16_t status) {
  const unsigned narrow = status & 0x4Fu;
  const unsigned wide = status & 0x6Fu;
  if (narrow == 0x00) return DriveState::not_ready;
  if (narrow == 0x40) return DriveState::switch_on_disabled;
  if (wide == 0x21) return DriveState::ready_to_switch_on;
  if (wide == 0x23) return DriveState::switched_on;
  if (wide == 0x27) return DriveState::operation_enabled;
  if (wide == 0x07) return DriveState::quick_stop;
  if (narrow == 0x0F) return DriveState::fault_reaction;
  if (narrow == 0x08) return DriveState::fault;
  return DriveState::unknown;
}

inline constexpr std::uint16_t kDisableVoltage = 0x00;
inline constexpr std::uint16_t kQuickStop = 0x02;
inline constexpr std::uint16_t kShutDown = 0x06;
inline constexpr std::uint16_t kSwitchOn = 0x07;
inline constexpr std::uint16_t kEnableOperation = 0x0F;
inline constexpr std::uint16_t kResetFault = 0x80;  ///< acts when the bit rises

/// Whether a motor may be under torque in this state; where nothing is known, it may.
constexpr bool may_have_torque(DriveState state) {
  return state != DriveState::switch_on_disabled && state != DriveState::ready_to_switch_on &&
         state != DriveState::fault && state != DriveState::not_ready;
}

/// The control word that leads from `state` towards what is wanted, one transition at a time. A fault is
/// reset only where `reset` says so; the bit must have been 0 in the word before, so ask with true every
/// other time.
constexpr std::uint16_t control_word(DriveState state, DriveWish wish, bool reset) {
  if (state == DriveState::fault) return reset ? kResetFault : kDisableVoltage;
  if (wish == DriveWish::quick_stop) return kQuickStop;
  if (wish == DriveWish::rest) return kDisableVoltage;
  switch (state) {
    case DriveState::switch_on_disabled:
      return kShutDown;
    case DriveState::ready_to_switch_on:
      return kSwitchOn;
    case DriveState::switched_on:
    case DriveState::operation_enabled:
      return kEnableOperation;
    default:
      return kDisableVoltage;  // a quick stop, too: it is left through its end, not back into operation
  }
}

}  // namespace sortie::drivers::canopen
