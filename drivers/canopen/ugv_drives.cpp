// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/canopen/ugv_drives.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sortie::drivers::canopen {
namespace {

// Tracks come first among the drives, flippers behind them.
constexpr std::size_t kTracks = 2;

std::vector<DriveConfig> drives_of(const UgvDrivesConfig& config) {
  if (!(config.increments_per_m >= 1.0 && config.increments_per_m <= 1e8) ||
      !(config.increments_per_rad >= 1.0 && config.increments_per_rad <= 1e8))
    throw std::runtime_error("canopen: increments a metre and a radian lie in 1 to 1e8");
  if (!(config.rated_torque_n_m > 0.0 && config.rated_torque_n_m <= 1e6))
    throw std::runtime_error("canopen: the rated torque must be above 0");
  DriveConfig drive;
  drive.master = config.master.node;
  drive.sync_period_ns = config.master.sync_period_ns;
  drive.heartbeat_ns = config.heartbeat_ns;
  drive.heartbeat_timeout_ns = config.heartbeat_timeout_ns;
  std::vector<DriveConfig> drives;
  for (const std::uint8_t node : config.track_nodes) {
    drive.node = node;
    drives.push_back(drive);
  }
  drive.kind = DriveKind::cyclic_position;
  for (const std::uint8_t node : config.flipper_nodes) {
    if (!config.flippers) break;
    drive.node = node;
    drives.push_back(drive);
  }
  return drives;
}

std::int32_t increments(double value, double per_unit) {
  return static_cast<std::int32_t>(std::floor(std::clamp(value * per_unit, -2.1e9, 2.1e9) + 0.5));
}

}  // namespace

std::int64_t IncrementCount::add(std::int32_t reading) noexcept {
  // The difference of unsigned numbers wraps as the counter does.
  const auto moved =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(reading) - static_cast<std::uint32_t>(last_));
  if (begun_) total_ += moved;
  begun_ = true;
  last_ = reading;
  return total_;
}

UgvDrives::UgvDrives(const UgvDrivesConfig& config)
    : config_(config), master_(config.master, drives_of(config)) {}

Status UgvDrives::set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept {
  if (!std::isfinite(command.left_m_s) || !std::isfinite(command.right_m_s)) return Status::not_finite;
  drive_on_ = (command.flags & 1u) != 0;
  targets_[0] = drive_on_ ? increments(command.left_m_s, config_.increments_per_m) : 0;
  targets_[1] = drive_on_ ? increments(command.right_m_s, config_.increments_per_m) : 0;
  pass_on(now_ns);
  return Status::ok;
}

Status UgvDrives::set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept {
  for (const double angle : command.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  flippers_on_ = (command.flags & 1u) != 0;
  for (std::size_t i = 0; i < rt::kFlippers; ++i)
    targets_[kTracks + i] = increments(command.angle_rad[i], config_.increments_per_rad);
  pass_on(now_ns);
  return Status::ok;
}

void UgvDrives::pass_on(rt::Nanoseconds now_ns) noexcept {
  // Flippers that nobody moves stay where they are.
  if (!flippers_on_ && config_.flippers) {
    for (std::size_t i = kTracks; i < master_.size(); ++i) targets_[i] = master_.drive(i).reading().position;
  }
  master_.set({targets_.data(), master_.size()}, drive_on_ || flippers_on_, now_ns);
}

bool UgvDrives::all_read(std::size_t first, std::size_t count) const noexcept {
  for (std::size_t i = first; i < first + count; ++i) {
    const Drive& drive = master_.drive(i);
    if (drive.phase() != DrivePhase::operational || drive.reading().stamp_ns < master_.sync_ns())
      return false;
  }
  return true;
}

Status UgvDrives::read(rt::TrackSample& sample) noexcept {
  if (master_.sync_ns() <= tracks_ns_ || !all_read(0, kTracks)) return Status::empty;
  tracks_ns_ = master_.sync_ns();
  sample = {};
  sample.stamp_ns = tracks_ns_;
  sample.left_m =
      static_cast<double>(travel_[0].add(master_.drive(0).reading().position)) / config_.increments_per_m;
  sample.right_m =
      static_cast<double>(travel_[1].add(master_.drive(1).reading().position)) / config_.increments_per_m;
  return Status::ok;
}

Status UgvDrives::read(rt::FlipperSample& sample) noexcept {
  if (!config_.flippers || master_.sync_ns() <= flippers_ns_ || !all_read(kTracks, rt::kFlippers))
    return Status::empty;
  flippers_ns_ = master_.sync_ns();
  sample = {};
  sample.stamp_ns = flippers_ns_;
  for (std::size_t i = 0; i < rt::kFlippers; ++i) {
    const DriveReading& reading = master_.drive(kTracks + i).reading();
    sample.angle_rad[i] = reading.position / config_.increments_per_rad;
    sample.torque_n_m[i] = 1e-3 * reading.torque * config_.rated_torque_n_m;
  }
  return Status::ok;
}

}  // namespace sortie::drivers::canopen
