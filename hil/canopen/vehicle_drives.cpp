// SPDX-License-Identifier: BSD-3-Clause
#include "hil/canopen/vehicle_drives.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::hil {
namespace {

constexpr std::size_t kTracks = 2;

// Encoders wrap at 32 bits.
std::int32_t wrapped(double increments) {
  const auto whole = static_cast<std::int64_t>(std::floor(increments));
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(whole)));
}

}  // namespace

VehicleDrives::VehicleDrives(const VehicleDrivesConfig& config, drivers::CanBus& port, bool flippers)
    : config_(config) {
  nodes_.reserve(kTracks + rt::kFlippers);
  if (!config.enabled) return;
  for (const std::uint8_t node : config.track_nodes) nodes_.emplace_back(node, port);
  if (!flippers) return;
  for (const std::uint8_t node : config.flipper_nodes) nodes_.emplace_back(node, port);
}

void VehicleDrives::show(const VehicleBody& body) noexcept {
  rt::FlipperSample flippers;
  static_cast<void>(body.read_flippers(flippers));  // without flippers there are no nodes for them
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    MotorState motor;
    double increments = 0.0;
    if (i < kTracks) {
      increments = (i == 0 ? body.motion().left_m : body.motion().right_m) * config_.increments_per_m;
    } else {
      increments = flippers.angle_rad[i - kTracks] * config_.increments_per_rad;
      const double share = 1000.0 * flippers.torque_n_m[i - kTracks] / config_.rated_torque_n_m;
      motor.torque = static_cast<std::int16_t>(std::clamp(share, -32767.0, 32767.0));
    }
    motor.position = wrapped(increments);
    // Steps are of a millisecond (hil/ugv_plant.hpp).
    motor.velocity = static_cast<std::int32_t>(std::clamp(1e3 * (increments - shown_[i]), -1e9, 1e9));
    shown_[i] = increments;
    nodes_[i].show(motor);
  }
}

void VehicleDrives::hear(const drivers::CanFrame& frame, rt::Nanoseconds now_ns) noexcept {
  for (CanopenNode& node : nodes_) node.hear(frame, now_ns);
}

void VehicleDrives::step(VehicleBody& body, rt::Nanoseconds now_ns) noexcept {
  if (nodes_.empty()) return;
  for (CanopenNode& node : nodes_) node.step(now_ns);
  MotorWishes wishes;
  wishes.flippers = nodes_.size() > kTracks;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    const MotorCommand& command = nodes_[i].command();
    const bool on = command.on && !command.quick_stop;
    if (i < kTracks) {
      wishes.track_on[i] = command.on;
      wishes.track_m_s[i] = on && command.mode == 3 ? command.velocity / config_.increments_per_m : 0.0;
    } else {
      wishes.moves[i - kTracks] = on && command.mode == 8;
      wishes.angle_rad[i - kTracks] = command.position / config_.increments_per_rad;
    }
  }
  tell_body(body, wishes, now_ns);
}

}  // namespace sortie::hil
