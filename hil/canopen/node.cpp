// SPDX-License-Identifier: BSD-3-Clause
#include "hil/canopen/node.hpp"

#include <stdexcept>

#include "drivers/canopen/drive_setup.hpp"

namespace sortie::hil {

namespace canopen = drivers::canopen;
using canopen::DriveState;
using canopen::NmtState;

namespace {

constexpr std::uint16_t kHeartbeatError = 0x8130;  // emergency: life guard or heartbeat
constexpr std::uint16_t kPdoLength = 0x8210;       // emergency: a PDO was too short
constexpr std::uint16_t kAbortVoltage = 2;         // of kAbortOption: no torque at once

// Status words: the state's bits, voltage enabled, remote.
std::uint16_t status_word(DriveState state) {
  constexpr std::uint16_t kBase = 0x0210;
  constexpr std::uint16_t kBits[] = {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08, 0x00};
  return static_cast<std::uint16_t>(kBase | kBits[static_cast<unsigned>(state)]);
}

}  // namespace

CanopenNode::CanopenNode(std::uint8_t node, drivers::CanBus& port)
    : port_(&port), objects_(node), node_(node) {
  if (node < 1 || node > canopen::kMaxNode)
    throw std::runtime_error("hil canopen: a node's number lies in 1 to 127");
}

void CanopenNode::show(const MotorState& motor) noexcept {
  objects_.set(canopen::kPositionActual, 0, static_cast<std::uint32_t>(motor.position));
  objects_.set(canopen::kVelocityActual, 0, static_cast<std::uint32_t>(motor.velocity));
  objects_.set(canopen::kTorqueActual, 0, static_cast<std::uint16_t>(motor.torque));
  if (state_ == DriveState::quick_stop && motor.velocity == 0) enter(DriveState::switch_on_disabled);
}

void CanopenNode::hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (!powered_ || !booted_) return;
  ++counters_.received;
  take(frame, now_ns);
}

void CanopenNode::step(rt::Nanoseconds now_ns) noexcept {
  if (!powered_) return;
  if (!booted_) boot();
  watch_master(now_ns);
  const auto period = static_cast<rt::Nanoseconds>(objects_.value(0x1017)) * rt::kNanosecondsPerMillisecond;
  if (period > 0 && now_ns >= next_heartbeat_ns_) {
    send(canopen::encode_heartbeat(node_, nmt_));
    next_heartbeat_ns_ = now_ns + period;
  }
}

void CanopenNode::boot() noexcept {
  booted_ = true;
  ++counters_.boots;
  objects_.reset();
  command_ = {};
  last_control_ = 0;
  master_known_ = false;
  next_heartbeat_ns_ = 0;
  enter(DriveState::switch_on_disabled);
  send(canopen::encode_heartbeat(node_, NmtState::boot_up));
  nmt_ = NmtState::pre_operational;
}

void CanopenNode::set_power(bool on) noexcept {
  powered_ = on;
  booted_ = false;
  enter(DriveState::switch_on_disabled);
}

void CanopenNode::fail(std::uint16_t code, int stubborn) noexcept {
  stubborn_ = stubborn;
  enter(DriveState::fault);
  emergency(code);
}

void CanopenNode::take(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  canopen::NmtCommand nmt{};
  std::uint8_t node = 0;
  if (canopen::decode_nmt(frame, nmt, node) == Status::ok) {
    if (node == 0 || node == node_) take_nmt(nmt);
    return;
  }
  NmtState state{};
  if (canopen::decode_heartbeat(frame, node, state) == Status::ok) {
    const std::uint32_t consumer = objects_.value(0x1016, 1);
    if (node == (consumer >> 16u & 0x7Fu)) {
      master_known_ = true;
      master_heard_ns_ = now_ns;
    }
    return;
  }
  canopen::Sdo request;
  if (canopen::decode_sdo_request(frame, node, request) == Status::ok) {
    if (node == node_ && nmt_ != NmtState::stopped) take_sdo(request);
    return;
  }
  if (nmt_ != NmtState::operational) return;
  if (canopen::is_sync(frame)) {
    if (objects_.value(0x1800, 2) == canopen::kPdoEverySync) send_tpdo();
  } else if (frame.flags == 0 && frame.id == (objects_.value(0x1400, 1) & 0x7FFu) &&
             (objects_.value(0x1400, 1) & canopen::kPdoOff) == 0) {
    take_rpdo(frame);
  }
}

void CanopenNode::take_nmt(canopen::NmtCommand command) noexcept {
  switch (command) {
    case canopen::NmtCommand::start:
      nmt_ = NmtState::operational;
      break;
    case canopen::NmtCommand::stop:
      nmt_ = NmtState::stopped;
      break;
    case canopen::NmtCommand::pre_operational:
      nmt_ = NmtState::pre_operational;
      break;
    case canopen::NmtCommand::reset_node:
    case canopen::NmtCommand::reset_communication:
      boot();
      return;
  }
  // Whoever leaves Operational gets no commands any more.
  if (nmt_ != NmtState::operational && state_ == DriveState::operation_enabled) enter(DriveState::quick_stop);
}

void CanopenNode::take_sdo(const canopen::Sdo& request) noexcept {
  if (request.kind == canopen::SdoKind::abort) return;
  canopen::Sdo reply;
  reply.key = request.key;
  std::uint32_t code = 0;
  if (request.kind == canopen::SdoKind::read) {
    reply.kind = canopen::SdoKind::value;
    code = objects_.read(request.key, reply.value, reply.bytes);
  } else {
    reply.kind = canopen::SdoKind::written;
    code = objects_.write(request.key, request.value, request.bytes, nmt_ == NmtState::operational);
    if (code == 0 && request.key.index == 0x1016) master_known_ = false;
    if (code == 0 && request.key.index == canopen::kModeWanted)
      objects_.set(canopen::kModeShown, 0, request.value);
    if (code == 0 && request.key.index == canopen::kControlWord)
      obey(static_cast<std::uint16_t>(request.value));
  }
  if (code != 0) {
    reply.kind = canopen::SdoKind::abort;
    reply.value = code;
  }
  send(canopen::encode_sdo_reply(node_, reply));
}

void CanopenNode::take_rpdo(const drivers::CanFrame& frame) noexcept {
  if (objects_.unpack(0x1600, frame) == 0) {
    emergency(kPdoLength);
    return;
  }
  obey(static_cast<std::uint16_t>(objects_.value(canopen::kControlWord)));
  command_.mode = static_cast<std::int8_t>(objects_.value(canopen::kModeWanted));
  command_.velocity = static_cast<std::int32_t>(objects_.value(canopen::kTargetVelocity));
  command_.position = static_cast<std::int32_t>(objects_.value(canopen::kTargetPosition));
}

// The consumer is armed by the first heartbeat that it hears (CiA 301, 7.5.2.14).
void CanopenNode::watch_master(rt::Nanoseconds now_ns) noexcept {
  const auto timeout =
      static_cast<rt::Nanoseconds>(objects_.value(0x1016, 1) & 0xFFFFu) * rt::kNanosecondsPerMillisecond;
  if (!master_known_ || timeout == 0 || now_ns - master_heard_ns_ <= timeout) return;
  master_known_ = false;
  ++counters_.heartbeat_lost;
  emergency(kHeartbeatError);
  const std::uint32_t option = objects_.value(canopen::kAbortOption);
  if (state_ != DriveState::operation_enabled) return;
  if (option == canopen::kAbortQuickStop) enter(DriveState::quick_stop);
  if (option == kAbortVoltage) enter(DriveState::switch_on_disabled);
  if (option == 1) enter(DriveState::fault);
}

// Transitions of CiA 402 by the control word's bits.
void CanopenNode::obey(std::uint16_t control) noexcept {
  const bool reset = (control & 0x80u) != 0 && (last_control_ & 0x80u) == 0;
  last_control_ = control;
  if (state_ == DriveState::fault) {
    if (!reset || stubborn_-- > 0) return;
    enter(DriveState::switch_on_disabled);
    emergency(0);
    return;
  }
  if ((control & 0x02u) == 0) {  // disable voltage
    enter(DriveState::switch_on_disabled);
  } else if ((control & 0x04u) == 0) {  // quick stop
    if (state_ == DriveState::operation_enabled) {
      enter(DriveState::quick_stop);
    } else if (state_ != DriveState::quick_stop) {
      enter(DriveState::switch_on_disabled);
    }
  } else if (state_ == DriveState::switch_on_disabled) {
    if ((control & 0x07u) == 0x06u) enter(DriveState::ready_to_switch_on);
  } else if (state_ == DriveState::ready_to_switch_on) {
    if ((control & 0x07u) == 0x07u) enter(DriveState::switched_on);
  } else if (state_ == DriveState::switched_on) {
    if ((control & 0x0Fu) == 0x0Fu) enter(DriveState::operation_enabled);
    if ((control & 0x07u) == 0x06u) enter(DriveState::ready_to_switch_on);
  } else if (state_ == DriveState::operation_enabled) {
    if ((control & 0x0Fu) == 0x07u) enter(DriveState::switched_on);
    if ((control & 0x07u) == 0x06u) enter(DriveState::ready_to_switch_on);
  }
}

void CanopenNode::enter(DriveState state) noexcept {
  state_ = state;
  objects_.set(canopen::kStatusWord, 0, status_word(state));
  command_.quick_stop = state == DriveState::quick_stop;
  command_.on = state == DriveState::operation_enabled || command_.quick_stop;
}

void CanopenNode::send_tpdo() noexcept {
  const std::uint32_t id = objects_.value(0x1800, 1);
  if ((id & canopen::kPdoOff) != 0) return;
  drivers::CanFrame frame;
  frame.id = id & 0x7FFu;
  frame.size = objects_.pack(0x1A00, frame);
  send(frame);
}

void CanopenNode::emergency(std::uint16_t code) noexcept {
  objects_.set(0x1001, 0, code == 0 ? 0u : 1u);
  send(canopen::encode_emergency(node_, {code, static_cast<std::uint8_t>(code == 0 ? 0 : 1)}));
}

void CanopenNode::send(const drivers::CanFrame& frame) noexcept {
  if (mute_) return;
  if (port_->send(frame) == Status::ok) {
    ++counters_.sent;
  } else {
    ++counters_.refused;
  }
}

}  // namespace sortie::hil
