// SPDX-License-Identifier: BSD-3-Clause
#include "hil/odrive/vehicle_axes.hpp"

namespace sortie::hil {
namespace {

constexpr std::size_t kTracks = 2;

}  // namespace

VehicleAxes::VehicleAxes(const VehicleAxesConfig& config, drivers::CanBus& port, bool flippers)
    : config_(config) {
  if (!config.enabled) return;
  nodes_.reserve(kTracks + rt::kFlippers);
  AxisNodeConfig axis;
  axis.watchdog_ns = config.watchdog_ns;
  axis.sends_current = false;
  for (const std::uint8_t node : config.track_nodes) {
    axis.node = node;
    nodes_.emplace_back(axis, port);
  }
  if (!flippers) return;
  axis.absolute = axis.sends_current = true;
  for (const std::uint8_t node : config.flipper_nodes) {
    axis.node = node;
    nodes_.emplace_back(axis, port);
  }
}

void VehicleAxes::show(const VehicleBody& body, rt::Nanoseconds now_ns) noexcept {
  rt::FlipperSample flippers;
  static_cast<void>(body.read_flippers(flippers));  // without flippers there are no axes for them
  const double passed_s = shown_ns_ < 0 ? 0.0 : 1e-9 * static_cast<double>(now_ns - shown_ns_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    AxisMotorState motor;
    if (i < kTracks) {
      motor.turns = (i == 0 ? body.motion().left_m : body.motion().right_m) * config_.turns_per_m;
    } else {
      motor.turns = flippers.angle_rad[i - kTracks] * config_.turns_per_rad;
      motor.current_a = flippers.torque_n_m[i - kTracks] / config_.torque_per_a_n_m;
    }
    if (passed_s > 0.0) motor.turns_s = (motor.turns - shown_turns_[i]) / passed_s;
    shown_turns_[i] = motor.turns;
    nodes_[i].show(motor);
  }
  shown_ns_ = now_ns;
}

void VehicleAxes::hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (AxisNode& node : nodes_) node.hear(frame, now_ns);
}

void VehicleAxes::step(VehicleBody& body, rt::Nanoseconds now_ns) noexcept {
  if (nodes_.empty()) return;
  MotorWishes wishes;
  wishes.flippers = nodes_.size() > kTracks;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].step(now_ns);
    const AxisMotorCommand& command = nodes_[i].command();
    if (i < kTracks) {
      wishes.track_on[i] = command.on;
      wishes.track_m_s[i] = command.on && !command.by_position ? command.turns_s / config_.turns_per_m : 0.0;
    } else {
      wishes.moves[i - kTracks] = command.on && command.by_position;
      wishes.angle_rad[i - kTracks] = command.turns / config_.turns_per_rad;
    }
  }
  tell_body(body, wishes, now_ns);
}

}  // namespace sortie::hil
