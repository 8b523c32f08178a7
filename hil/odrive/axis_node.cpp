// SPDX-License-Identifier: BSD-3-Clause
#include "hil/odrive/axis_node.hpp"

#include <algorithm>
#include <cmath>

#include "drivers/odrive_dbc.hpp"
#include "hil/requirement.hpp"

namespace sortie::hil {

namespace odrive = drivers::odrive;

// Of a step of a millisecond: what its own estimate of speed takes over of what is true.
constexpr double kEstimateShare = 0.1;
using odrive::AxisState;

AxisNode::AxisNode(const AxisNodeConfig& config, drivers::CanBus& port) : config_(config), port_(&port) {
  require("odrive", config.node <= odrive::kMaxNode, "an axis has a number of 0 to 63");
}

void AxisNode::show(const AxisMotorState& motor) noexcept {
  const bool slows = command_.on && motor.turns_s * (motor.turns_s - motor_.turns_s) < 0.0;
  const double slowing_turn_s2 = 1e3 * std::fabs(motor.turns_s - motor_.turns_s);
  regenerates_too_much_ =
      slows && config_.bus_trip_turn_s2 > 0.0 && slowing_turn_s2 > config_.bus_trip_turn_s2;
  motor_ = motor;
  estimate_turn_s_ += kEstimateShare * (motor.turns_s - estimate_turn_s_);
}

AxisWish AxisNode::wish() const noexcept {
  AxisWish wish;
  if (!command_.on) return wish;
  wish.deed = command_.by_position ? AxisDeed::position : AxisDeed::speed;
  wish.target = command_.by_position ? command_.turns : command_.turns_s;
  wish.ramp_s2 = config_.fastest_turn_s2;
  wish.fastest = velocity_limit_;
  return wish;
}

void AxisNode::boot() noexcept {
  booted_ = true;
  ++counters_.boots;
  command_ = {};
  error_ = config_.boot_error;
  velocity_limit_ = 2.0;
  current_limit_ = 10.0;
  origin_turns_ = config_.absolute ? 0.0 : motor_.turns;
  fed_ns_ = -1;
  enter(AxisState::idle);
}

void AxisNode::set_power(bool on) noexcept {
  powered_ = on;
  booted_ = false;
  power_ns_ = -1;
  stubborn_ = 0;
  enter(AxisState::idle);
}

void AxisNode::fail(std::uint32_t error, int stubborn) noexcept {
  error_ |= error;
  stubborn_ = stubborn;
  enter(AxisState::idle);
}

void AxisNode::ask(AxisState state, rt::Nanoseconds now_ns) noexcept {
  if (state == AxisState::idle) {
    enter(state);
  } else if (state != AxisState::closed_loop) {
    fail(kInvalidState);
  } else if (error_ == 0 && state_ != state && closed_ns_ < 0) {
    if (calibrated_) {
      closed_ns_ = now_ns + config_.enter_ns;
    } else {
      fail(kNotCalibrated);
    }
  }
}

// An axis that comes under torque starts from rest where it is.
void AxisNode::enter(AxisState state) noexcept {
  if (state == AxisState::closed_loop && state_ != state) {
    command_.turns_s = 0.0;
    command_.turns = motor_.turns;
  }
  closed_ns_ = -1;
  state_ = state;
  command_.on = state == AxisState::closed_loop;
}

void AxisNode::hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  if (!powered_ || !booted_ || deaf_ || frame.flags != 0 || frame.id >> 5u != config_.node) return;
  ++counters_.received;
  const std::uint32_t id = frame.id & 0x1Fu;
  const auto is = [&](const drivers::CanMessage& message) {
    return id == message.id && frame.size == message.size;
  };
  if (!config_.targets_alone_feed || is(odrive::kSetInputVel) || is(odrive::kSetInputPos)) fed_ns_ = now_ns;
  if (disobeys_) return;
  if (is(odrive::kSetAxisState)) {
    ask(static_cast<AxisState>(drivers::read_can_field(frame, odrive::kSetAxisStateSignals[0])), now_ns);
  } else if (is(odrive::kSetControllerMode)) {
    command_.by_position = drivers::read_can_field(frame, odrive::kSetControllerModeSignals[0]) == 3;
    command_.turns = motor_.turns;  // a mode begins where the axis is
  } else if (is(odrive::kSetLimits)) {
    // A negative limit, or none at all, lets nothing move.
    velocity_limit_ = std::max(0.0, drivers::physical_can_field(frame, odrive::kSetLimitsSignals[0]));
    current_limit_ = drivers::physical_can_field(frame, odrive::kSetLimitsSignals[1]);
  } else if (is(odrive::kSetInputVel)) {
    const double wish = drivers::physical_can_field(frame, odrive::kSetInputVelSignals[0]);
    command_.turns_s = std::clamp(wish, -velocity_limit_, velocity_limit_);
  } else if (is(odrive::kSetInputPos)) {
    command_.turns = origin_turns_ + drivers::physical_can_field(frame, odrive::kSetInputPosSignals[0]);
  } else if (is(odrive::kClearErrors)) {
    if (stubborn_ > 0) {
      --stubborn_;
    } else {
      error_ = 0;
    }
  }
}

void AxisNode::step(rt::Nanoseconds now_ns) noexcept {
  if (!powered_) return;
  if (power_ns_ < 0) power_ns_ = now_ns;
  if (!booted_) {
    if (now_ns - power_ns_ < config_.boot_ns) return;
    boot();
  }
  if (closed_ns_ >= 0 && now_ns >= closed_ns_) enter(AxisState::closed_loop);
  watch(now_ns);
  if (now_ns >= next_heartbeat_ns_) {
    drivers::CanFrame frame;
    frame.id = odrive::kHeartbeat.id;
    drivers::write_can_field(frame, odrive::kHeartbeatSignals[0], error_);
    drivers::write_can_field(frame, odrive::kHeartbeatSignals[1], static_cast<std::int64_t>(state_));
    send(frame);
    next_heartbeat_ns_ = now_ns + config_.heartbeat_ns;
  }
  if (now_ns >= next_estimates_ns_) {
    send_estimates();
    next_estimates_ns_ = now_ns + config_.estimates_ns;
  }
}

void AxisNode::watch(rt::Nanoseconds now_ns) noexcept {
  const bool watched = config_.watchdog_ns != 0 && fed_ns_ >= 0 && (command_.on || config_.watched_when_idle);
  if (watched && now_ns - fed_ns_ > config_.watchdog_ns && (error_ & kWatchdogExpired) == 0) {
    ++counters_.watchdog;
    fail(kWatchdogExpired);
  }
  if (!voltage_ && (error_ & kBusVoltage) == 0) fail(kBusVoltage);
  if (!command_.on) return;
  const bool fast =
      config_.overspeed > 0.0 && std::fabs(estimate_turn_s_) > config_.overspeed * velocity_limit_;
  if (!fast && !regenerates_too_much_) return;
  ++counters_.trips;
  fail(fast ? kOverspeed : kBusVoltage);
}

void AxisNode::send_estimates() noexcept {
  drivers::CanFrame frame;
  frame.id = odrive::kEncoderEstimates.id;
  // What is not finite stays out: the simulation's numbers are.
  static_cast<void>(
      drivers::set_can_field(frame, odrive::kEncoderEstimatesSignals[0], motor_.turns - origin_turns_));
  static_cast<void>(drivers::set_can_field(frame, odrive::kEncoderEstimatesSignals[1], motor_.turns_s));
  send(frame);
  if (!config_.sends_current) return;
  frame = {};
  frame.id = odrive::kIq.id;
  static_cast<void>(drivers::set_can_field(frame, odrive::kIqSignals[1], motor_.current_a));
  send(frame);
}

void AxisNode::send(drivers::CanFrame frame) noexcept {
  if (mute_) return;
  frame.id |= static_cast<std::uint32_t>(config_.node) << 5u;
  frame.size = 8;
  ++(port_->send(frame) == Status::ok ? counters_.sent : counters_.refused);
}

}  // namespace sortie::hil
