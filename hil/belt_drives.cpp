// SPDX-License-Identifier: BSD-3-Clause
#include "hil/belt_drives.hpp"

#include <algorithm>
#include <cmath>

#include "hil/requirement.hpp"

namespace sortie::hil {
namespace {

const BeltDriveConfig& checked(const BeltDriveConfig& c, rt::Nanoseconds step_ns, const char* owner) {
  require(owner, step_ns > 0 && step_ns <= rt::kNanosecondsPerSecond, "the step must lie in 1 ns to 1 s");
  require(owner, c.speed_lag_s >= 1e-4, "speed_lag_s must be at least 0.0001");
  require(owner, c.max_speed_m_s > 0.0 && c.max_acceleration_m_s2 > 0.0,
          "max_speed_m_s and max_acceleration_m_s2 must be above 0");
  require(owner, c.command_timeout_s > 0.0 && c.command_timeout_s < 3600.0,
          "command_timeout_s must be above 0 and below an hour");
  require(owner, c.coast_friction_m_s2 > 0.0, "coast_friction_m_s2 must be above 0");
  return c;
}

}  // namespace

BeltDrives::BeltDrives(const BeltDriveConfig& config, rt::Nanoseconds step_ns, const char* owner)
    : max_speed_m_s_(checked(config, step_ns, owner).max_speed_m_s),
      timeout_ns_(static_cast<rt::Nanoseconds>(config.command_timeout_s * 1e9)),
      left_(config.speed_lag_s, config.max_acceleration_m_s2, rt::to_seconds(step_ns)),
      right_(left_),
      friction_m_s2_(config.coast_friction_m_s2) {}

Status BeltDrives::set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) {
  if (!std::isfinite(command.left_m_s) || !std::isfinite(command.right_m_s)) return Status::not_finite;
  command_ = command;
  command_ns_ = now_ns;
  commanded_ = true;
  ++commands_;
  return Status::ok;
}

void BeltDrives::advance(rt::Nanoseconds now_ns, double push_m_s2) {
  const bool fresh = commanded_ && now_ns - command_ns_ <= timeout_ns_;
  if (commanded_ && !fresh) ++stale_steps_;
  const bool drive = fresh && (command_.flags & 1u) != 0;
  const auto move = [&](TrackDrive& belt, bool free, double wish_m_s) {
    if (free) {
      belt.coast(push_m_s2, friction_m_s2_);
    } else {
      belt.advance(drive ? std::clamp(wish_m_s, -max_speed_m_s_, max_speed_m_s_) : 0.0);
    }
  };
  move(left_, left_free_, command_.left_m_s);
  move(right_, right_free_, command_.right_m_s);
}

}  // namespace sortie::hil
