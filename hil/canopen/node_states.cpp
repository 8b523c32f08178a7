// SPDX-License-Identifier: BSD-3-Clause
// The simulated drive's state machine (CiA 402), and what its motor does in each state.
#include <cstdlib>

#include "drivers/canopen/drive_setup.hpp"
#include "hil/canopen/node.hpp"

namespace sortie::hil {

namespace canopen = drivers::canopen;
using canopen::DriveState;

namespace {

constexpr std::uint16_t kAbortVoltage = 2;  // of kAbortOption: no torque at once

// Status words: the state's bits, voltage enabled, remote.
std::uint16_t status_word(DriveState state, bool voltage) {
  constexpr std::uint16_t kBits[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08, 0x00};
  return static_cast<std::uint16_t>(0x0200u | (voltage ? 0x10u : 0u) | kBits[static_cast<unsigned>(state)]);
}

}  // namespace

void CanopenNode::show(const MotorState& motor) noexcept {
  motor_ = motor;
  objects_.set(canopen::kPositionActual, 0, static_cast<std::uint32_t>(motor.position));
  objects_.set(canopen::kVelocityActual, 0, static_cast<std::uint32_t>(motor.velocity));
  objects_.set(canopen::kTorqueActual, 0, static_cast<std::uint16_t>(motor.torque));
  const bool stands = std::abs(motor.velocity) < 20;
  // Options 5 and 6 keep it under torque.
  if (state_ == DriveState::quick_stop && stands && objects_.value(0x605A) < 5)
    enter(DriveState::switch_on_disabled);
  if (state_ == DriveState::fault_reaction && stands) enter(DriveState::fault);
}

AxisWish CanopenNode::wish() const noexcept {
  AxisWish wish;
  wish.brake_open = command_.brake_open;
  if (!command_.on) return wish;
  const bool follows = state_ == DriveState::operation_enabled;
  const bool by_position = command_.mode == static_cast<std::int8_t>(canopen::DriveKind::cyclic_position);
  wish.deed = follows && by_position ? AxisDeed::position : AxisDeed::speed;
  if (follows && by_position) {
    wish.target = command_.position;
  } else if (follows && command_.mode == static_cast<std::int8_t>(canopen::DriveKind::velocity)) {
    wish.target = command_.velocity;
  }
  wish.fastest = 4.0 * kUsualRamp;
  wish.ramp_s2 = command_.ramp;
  return wish;
}

// What object 0x6007 says of it.
void CanopenNode::lose_connection() noexcept {
  const std::uint32_t option = objects_.value(canopen::kAbortOption);
  if (!command_.on || state_ == DriveState::fault_reaction) return;
  wanted_ = DriveState::switch_on_disabled;
  if (option == canopen::kAbortQuickStop) enter(DriveState::quick_stop);
  if (option == kAbortVoltage) enter(DriveState::switch_on_disabled);
  if (option == 1) fail(kHeartbeatError);
}

// Transitions of CiA 402 by the control word's bits.
void CanopenNode::obey(std::uint16_t control) noexcept {
  const bool reset = (control & 0x80u) != 0 && (last_control_ & 0x80u) == 0;
  last_control_ = control;
  if (state_ == DriveState::fault_reaction) return;
  if (state_ == DriveState::fault) {
    if (!reset || stubborn_ == kForGood || stubborn_-- > 0) return;
    enter(DriveState::switch_on_disabled);
    emergency(0);
    return;
  }
  if ((control & 0x02u) == 0) {  // disable voltage
    enter(DriveState::switch_on_disabled);
  } else if ((control & 0x04u) == 0) {  // quick stop
    wanted_ = DriveState::switch_on_disabled;
    if (state_ == DriveState::operation_enabled) {
      enter(objects_.value(0x605A) == 0 ? DriveState::switch_on_disabled : DriveState::quick_stop);
    } else if (state_ != DriveState::quick_stop) {
      enter(wanted_);
    }
  } else if (state_ == DriveState::switch_on_disabled) {
    if ((control & 0x07u) == 0x06u) rise(DriveState::ready_to_switch_on);
  } else if (state_ == DriveState::ready_to_switch_on) {
    if ((control & 0x07u) == 0x07u) rise(DriveState::switched_on);
  } else if (state_ == DriveState::switched_on) {
    if ((control & 0x0Fu) == 0x0Fu) rise(DriveState::operation_enabled);
    if ((control & 0x07u) == 0x06u) enter(DriveState::ready_to_switch_on);
  } else if (state_ == DriveState::operation_enabled) {
    if ((control & 0x0Fu) == 0x07u) enter(DriveState::switched_on);
    if ((control & 0x07u) == 0x06u) enter(DriveState::ready_to_switch_on);
  }
}

rt::Nanoseconds CanopenNode::rise_time(DriveState to) const noexcept {
  return config_.transition_ns +
         (config_.brake && to == DriveState::operation_enabled ? config_.brake_ns : 0);
}

// A step towards torque, which takes its time.
void CanopenNode::rise(DriveState state) noexcept {
  if (wanted_ == state) return;
  if (block_ == EnableBlock::safe_torque_off || block_ == EnableBlock::no_voltage) return;
  wanted_ = state;
  rise_ns_ = now_ns_ + rise_time(state);
  // Torque comes before the brake opens.
  if (state == DriveState::operation_enabled && config_.brake) command_.on = true;
}

void CanopenNode::take_steps(rt::Nanoseconds now_ns) noexcept {
  const bool rises =
      wanted_ != state_ && (wanted_ == DriveState::ready_to_switch_on || wanted_ == DriveState::switched_on ||
                            wanted_ == DriveState::operation_enabled);
  if (!rises || now_ns < rise_ns_) return;
  if (wanted_ == DriveState::operation_enabled && block_ == EnableBlock::brake) return;
  enter(wanted_);
}

void CanopenNode::enter(DriveState state) noexcept {
  state_ = state;
  if (state != DriveState::quick_stop && state != DriveState::fault_reaction) wanted_ = state;
  objects_.set(canopen::kStatusWord, 0, status_word(state, block_ != EnableBlock::no_voltage));
  command_.quick_stop = state == DriveState::quick_stop || state == DriveState::fault_reaction;
  command_.on = state == DriveState::operation_enabled || command_.quick_stop;
  command_.brake_open = command_.on;
  const bool slow =
      state == DriveState::quick_stop && objects_.value(0x605A) != 2 && objects_.value(0x605A) != 6;
  command_.ramp = static_cast<std::int32_t>(objects_.value(!command_.quick_stop ? 0x6083
                                                           : slow               ? 0x6084
                                                                                : 0x6085));
}

}  // namespace sortie::hil
