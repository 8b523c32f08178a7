// SPDX-License-Identifier: BSD-3-Clause
#include "hil/canopen/node.hpp"

#include <cstdlib>

#include "drivers/canopen/drive_setup.hpp"
#include "hil/requirement.hpp"

namespace sortie::hil {

namespace canopen = drivers::canopen;
using canopen::DriveState;
using canopen::NmtState;

namespace {

constexpr std::uint16_t kPdoLength = 0x8210;  // emergency: a PDO was too short
constexpr std::uint16_t kPdoTimeout = 0x8250;
constexpr std::uint16_t kSyncTimeout = 0x8700;
constexpr std::uint16_t kFollowingError = 0x8611;

rt::Nanoseconds ms(std::uint32_t value) {
  return static_cast<rt::Nanoseconds>(value) * rt::kNanosecondsPerMillisecond;
}

}  // namespace

CanopenNode::CanopenNode(std::uint8_t node, drivers::CanBus& port, const CanopenNodeConfig& config)
    : port_(&port), config_(config), objects_(node), node_(node) {
  require("canopen", node >= 1 && node <= canopen::kMaxNode, "a node's number lies in 1 to 127");
}

void CanopenNode::hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (!powered_ || !booted_ || deaf_) return;
  ++counters_.received;
  take(frame, now_ns);
}

void CanopenNode::step(rt::Nanoseconds now_ns) noexcept {
  now_ns_ = now_ns;
  if (!powered_) return;
  if (power_ns_ < 0) power_ns_ = now_ns;
  if (!booted_) {
    if (now_ns - power_ns_ < config_.boot_ns) return;
    boot(now_ns);
  }
  if (block_ == EnableBlock::safe_torque_off || block_ == EnableBlock::no_voltage) {
    wanted_ = DriveState::switch_on_disabled;
    if (state_ != DriveState::fault && state_ != DriveState::switch_on_disabled) enter(wanted_);
  }
  take_steps(now_ns);
  watch_master(now_ns);
  watch_motor(now_ns);
  if (sdo_waits_ && now_ns >= sdo_due_ns_) answer_sdo();
  const rt::Nanoseconds period = ms(objects_.value(0x1017));
  if (period > 0 && now_ns >= next_heartbeat_ns_) {
    send(canopen::encode_heartbeat(node_, nmt_));
    next_heartbeat_ns_ = now_ns + period;
  }
}

void CanopenNode::boot(rt::Nanoseconds now_ns) noexcept {
  booted_ = true;
  ++counters_.boots;
  follows_ns_ = sync_ns_ = rpdo_ns_ = now_ns;
  reset();
}

// Reset of node or communication alike: all is forgotten.
void CanopenNode::reset() noexcept {
  objects_.reset();
  command_ = {};
  last_control_ = 0;
  master_known_ = sdo_waits_ = false;
  next_heartbeat_ns_ = 0;
  enter(DriveState::switch_on_disabled);
  send(canopen::encode_heartbeat(node_, NmtState::boot_up));
  nmt_ = NmtState::pre_operational;
}

void CanopenNode::set_power(bool on) noexcept {
  powered_ = on;
  booted_ = false;
  power_ns_ = -1;
  stubborn_ = 0;
  enter(DriveState::switch_on_disabled);
}

void CanopenNode::fail(std::uint16_t code, int stubborn) noexcept {
  if (!powered_ || !booted_) return;
  stubborn_ = stubborn;
  ++counters_.faults;
  // What can still be steered is stopped on its ramp where the drive was told to; what cannot, coasts.
  const bool can_stop = command_.on && code >= 0x8000 && objects_.value(0x605E) != 0;
  wanted_ = DriveState::fault;
  enter(can_stop ? DriveState::fault_reaction : DriveState::fault);
  emergency(code);
}

void CanopenNode::take(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  canopen::NmtCommand nmt{};
  std::uint8_t node = 0;
  if (!heartbeats_alone_ && canopen::decode_nmt(frame, nmt, node) == Status::ok) {
    if (node == 0 || node == node_) take_nmt(nmt, now_ns);
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
  if (heartbeats_alone_) return;
  canopen::Sdo request;
  if (canopen::decode_sdo_request(frame, node, request) == Status::ok) {
    if (node == node_ && nmt_ != NmtState::stopped) take_sdo(request, now_ns);
    return;
  }
  if (nmt_ != NmtState::operational) return;
  if (canopen::is_sync(frame)) {
    sync_ns_ = now_ns;
    if (objects_.value(0x1800, 2) == canopen::kPdoEverySync) send_tpdo();
  } else if (frame.flags == 0 && frame.id == (objects_.value(0x1400, 1) & 0x7FFu) &&
             (objects_.value(0x1400, 1) & canopen::kPdoOff) == 0) {
    rpdo_ns_ = now_ns;
    take_rpdo(frame);
  }
}

void CanopenNode::take_nmt(canopen::NmtCommand command, rt::Nanoseconds now_ns) noexcept {
  switch (command) {
    case canopen::NmtCommand::start:
      if (nmt_ != NmtState::operational) sync_ns_ = rpdo_ns_ = now_ns;
      nmt_ = NmtState::operational;
      break;
    case canopen::NmtCommand::stop:
      if (nmt_ != NmtState::stopped && config_.stopped_matters) lose_connection();
      nmt_ = NmtState::stopped;
      break;
    // Its state machine does not care: an enabled drive stays enabled, on its last target.
    case canopen::NmtCommand::pre_operational:
      nmt_ = NmtState::pre_operational;
      break;
    case canopen::NmtCommand::reset_node:
    case canopen::NmtCommand::reset_communication:
      reset();
      return;
  }
}

void CanopenNode::take_sdo(const canopen::Sdo& request, rt::Nanoseconds now_ns) noexcept {
  if (request.kind == canopen::SdoKind::abort) return;
  request_ = request;
  sdo_waits_ = true;
  sdo_due_ns_ = now_ns + config_.sdo_ns;
}

void CanopenNode::answer_sdo() noexcept {
  sdo_waits_ = false;
  canopen::Sdo reply;
  reply.key = request_.key;
  std::uint32_t code = 0;
  if (request_.kind == canopen::SdoKind::read) {
    reply.kind = canopen::SdoKind::value;
    code = objects_.read(request_.key, reply.value, reply.bytes);
  } else {
    reply.kind = canopen::SdoKind::written;
    code = objects_.write(request_.key, request_.value, request_.bytes, nmt_ == NmtState::operational);
    if (code == 0 && request_.key.index == 0x1016) master_known_ = false;
    if (code == 0 && request_.key.index == canopen::kModeWanted) {
      objects_.set(canopen::kModeShown, 0, request_.value);
      command_.mode = static_cast<std::int8_t>(request_.value);
    }
    if (code == 0 && request_.key.index == canopen::kControlWord)
      obey(static_cast<std::uint16_t>(request_.value));
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
  command_.mode = static_cast<std::int8_t>(objects_.value(canopen::kModeWanted));
  command_.velocity = static_cast<std::int32_t>(objects_.value(canopen::kTargetVelocity));
  command_.position = static_cast<std::int32_t>(objects_.value(canopen::kTargetPosition));
  obey(static_cast<std::uint16_t>(objects_.value(canopen::kControlWord)));
}

// The consumer is armed by the first heartbeat that it hears (CiA 301, 7.5.2.14).
void CanopenNode::watch_master(rt::Nanoseconds now_ns) noexcept {
  const rt::Nanoseconds timeout = ms(objects_.value(0x1016, 1) & 0xFFFFu);
  if (master_known_ && timeout != 0 && now_ns - master_heard_ns_ > timeout) {
    master_known_ = false;
    ++counters_.heartbeat_lost;
    emergency(kHeartbeatError);
    lose_connection();
    if (nmt_ == NmtState::operational && objects_.value(0x1029, 1) == 0) nmt_ = NmtState::pre_operational;
  }
  if (nmt_ != NmtState::operational || state_ != DriveState::operation_enabled) return;
  const rt::Nanoseconds rpdo_ns = ms(objects_.value(0x1400, 5));
  if (rpdo_ns > 0 && now_ns - rpdo_ns_ > rpdo_ns) fail(kPdoTimeout);
  if (config_.sync_timeout_ns > 0 && now_ns - sync_ns_ > config_.sync_timeout_ns) fail(kSyncTimeout);
}

void CanopenNode::watch_motor(rt::Nanoseconds now_ns) noexcept {
  const std::uint32_t window = objects_.value(0x6065);
  const bool by_position = command_.mode == static_cast<std::int8_t>(canopen::DriveKind::cyclic_position);
  const bool follows =
      state_ != DriveState::operation_enabled || !by_position || window == 0 ||
      std::abs(static_cast<std::int64_t>(command_.position) - motor_.position) <= std::int64_t{window};
  if (follows) follows_ns_ = now_ns;
  if (now_ns - follows_ns_ > ms(objects_.value(0x6066))) fail(kFollowingError);
}

void CanopenNode::send_tpdo() noexcept {
  const std::uint32_t id = objects_.value(0x1800, 1);
  if ((id & canopen::kPdoOff) != 0 || no_readings_) return;
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
  ++(port_->send(frame) == Status::ok ? counters_.sent : counters_.refused);
}

}  // namespace sortie::hil
