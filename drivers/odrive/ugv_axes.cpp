// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/odrive/ugv_axes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "drivers/can_frames.hpp"
#include "drivers/odrive_dbc.hpp"

namespace sortie::drivers::odrive {
namespace {

constexpr rt::Nanoseconds kFarthest = 20 * rt::kNanosecondsPerMillisecond;  // that an estimate is moved on

// An axis owns 32 identifiers; the robot's own frames must not lie among them.
void refuse_own_frames(std::uint8_t node) {
  for (const CanMessage& message : kCanFrames) {
    if (message.id >> 5u == node)
      throw std::runtime_error("odrive: the identifiers of axis " + std::to_string(node) +
                               " are those of the robot's own frames; take a number below 8 or above 10");
  }
}

std::vector<AxisConfig> axes_of(const UgvAxesConfig& config) {
  if (!(config.turns_per_m >= 1e-3 && config.turns_per_m <= 1e6) ||
      !(config.turns_per_rad >= 1e-3 && config.turns_per_rad <= 1e6))
    throw std::runtime_error("odrive: turns a metre and a radian lie in 0.001 to 1e6");
  if (!std::isfinite(config.torque_per_a_n_m))
    throw std::runtime_error("odrive: the torque of an ampere must be a number");
  AxisConfig axis;
  axis.velocity_limit_turn_s = config.velocity_limit_turn_s;
  axis.current_limit_a = config.current_limit_a;
  axis.silence_ns = config.silence_ns;
  axis.prove_watchdog = config.prove_watchdog;
  std::vector<AxisConfig> axes;
  const auto add = [&](std::uint8_t node) {
    refuse_own_frames(node);
    axis.node = node;
    axes.push_back(axis);
  };
  for (const std::uint8_t node : config.track_nodes) add(node);
  axis.kind = AxisKind::position;
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) add(node);
  }
  return axes;
}

}  // namespace

UgvAxes::UgvAxes(const UgvAxesConfig& config)
    : UgvDrives(config.group, config.flippers, config.turns_per_m, config.turns_per_rad),
      config_(config),
      line_(config.period_ns, axes_of(config)) {
  attach_all();
}

UgvAxes::UgvAxes(const UgvAxes& other)
    : UgvDrives(other),
      config_(other.config_),
      line_(other.line_),
      used_(other.used_),
      set_ups_(other.set_ups_),
      origin_(other.origin_),
      travel_(other.travel_),
      tracks_ns_(other.tracks_ns_),
      flippers_ns_(other.flippers_ns_) {
  attach_all();
}

void UgvAxes::attach_all() {
  std::array<MotorDrive*, kMaxDrives> axes{};
  for (std::size_t i = 0; i < line_.size(); ++i) axes[i] = &line_.axis(i);
  attach({axes.data(), line_.size()});
}

void UgvAxes::poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept {
  line_.watch(!pressed(), now_ns);
  std::array<double, kMaxDrives> standing{};
  for (std::size_t i = 0; i < line_.size(); ++i) standing[i] = line_.axis(i).reading().turns;
  decide(line_.works(now_ns), {standing.data(), line_.size()}, now_ns);
  line_.send(now_ns, bus);
}

// New readings of all these axes, near enough to each other; `stamp_ns`: of the last.
bool UgvAxes::together(std::size_t first, std::size_t count, rt::Nanoseconds& stamp_ns) noexcept {
  rt::Nanoseconds oldest = line_.axis(first).reading().stamp_ns;
  stamp_ns = oldest;
  for (std::size_t i = first; i < first + count; ++i) {
    const Axis& axis = line_.axis(i);
    if (axis.phase() != AxisPhase::ready || axis.reading().number == used_[i]) return false;
    oldest = std::min(oldest, axis.reading().stamp_ns);
    stamp_ns = std::max(stamp_ns, axis.reading().stamp_ns);
  }
  if (stamp_ns - oldest > kFarthest) return false;
  for (std::size_t i = first; i < first + count; ++i) used_[i] = line_.axis(i).reading().number;
  return true;
}

double UgvAxes::turns_at(std::size_t i, rt::Nanoseconds stamp_ns) const noexcept {
  const AxisReading& reading = line_.axis(i).reading();
  return reading.turns + reading.turns_s * 1e-9 * static_cast<double>(stamp_ns - reading.stamp_ns);
}

Status UgvAxes::read(rt::TrackSample& sample) noexcept {
  rt::Nanoseconds stamp_ns = 0;
  if (!together(0, kTracks, stamp_ns) || stamp_ns <= tracks_ns_) return Status::empty;
  tracks_ns_ = stamp_ns;
  for (std::size_t i = 0; i < kTracks; ++i) {
    const double turns = turns_at(i, stamp_ns);
    // An axis that came back may count from zero again: travel goes on from where it was.
    if (set_ups_[i] != line_.axis(i).counters().set_ups) origin_[i] = turns - travel_[i];
    set_ups_[i] = line_.axis(i).counters().set_ups;
    travel_[i] = turns - origin_[i];
  }
  sample = {};
  sample.stamp_ns = stamp_ns;
  sample.left_m = travel_[0] / config_.turns_per_m;
  sample.right_m = travel_[1] / config_.turns_per_m;
  return Status::ok;
}

Status UgvAxes::read(rt::FlipperSample& sample) noexcept {
  rt::Nanoseconds stamp_ns = 0;
  if (!config_.flippers || !together(kTracks, rt::kFlippers, stamp_ns) || stamp_ns <= flippers_ns_)
    return Status::empty;
  flippers_ns_ = stamp_ns;
  sample = {};
  sample.stamp_ns = stamp_ns;
  for (std::size_t i = 0; i < rt::kFlippers; ++i) {
    sample.angle_rad[i] = turns_at(kTracks + i, stamp_ns) / config_.turns_per_rad;
    sample.torque_n_m[i] = line_.axis(kTracks + i).reading().current_a * config_.torque_per_a_n_m;
  }
  return Status::ok;
}

// Frames of set-up and of states come rarely and are left out.
std::vector<CanStream> bus_frames(const UgvAxesConfig& config) {
  constexpr rt::Nanoseconds kEstimates = 10 * rt::kNanosecondsPerMillisecond;  // as an axis comes
  std::vector<CanStream> frames;
  const auto add = [&](const char* what, std::uint8_t node, const CanMessage& message,
                       rt::Nanoseconds period_ns) {
    frames.push_back({.name = std::string(what) + " of axis " + std::to_string(node),
                      .id = message.id | static_cast<std::uint32_t>(node) << 5u,
                      .size = message.size,
                      .period_ns = period_ns});
  };
  const auto axis = [&](std::uint8_t node, bool flipper) {
    add("command", node, flipper ? kSetInputPos : kSetInputVel, config.period_ns);
    frames.back().queue = 0;  // ours leave through one interface
    add("estimates", node, kEncoderEstimates, kEstimates);
    if (flipper) add("current", node, kIq, kEstimates);
    add("heartbeat", node, kHeartbeat, config.silence_ns / 3);
  };
  for (const std::uint8_t node : config.track_nodes) axis(node, false);
  for (const std::uint8_t node : config.flipper_nodes) {
    if (config.flippers) axis(node, true);
  }
  return frames;
}

}  // namespace sortie::drivers::odrive
