// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/ugv_drives.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace sortie::drivers {
namespace {

// A pause is not made up for at once.
constexpr rt::Nanoseconds kLongestStep = 20 * rt::kNanosecondsPerMillisecond;

// Torque through whatever makes the robot wait: what is wanted and not enabled holds.
SourceSays says(std::uint32_t flags) {
  return (flags & (rt::kCommandEnabled | rt::kCommandWanted)) != 0 ? SourceSays::on : SourceSays::off;
}
rt::Nanoseconds made_at(rt::Nanoseconds stamp_ns, rt::Nanoseconds now_ns) {
  return stamp_ns == 0 ? now_ns : stamp_ns;
}

}  // namespace

UgvDrives::UgvDrives(const UgvDrivesConfig& config) : config_(config), group_(config.group) {
  if (!(config.soft_start_m_s2 > 0.0 && config.soft_start_rad_s > 0.0))
    throw std::runtime_error("drives: the rates of a soft start must be above 0");
}

void UgvDrives::attach(std::span<MotorDrive* const> drives) {
  std::array<std::uint8_t, kMaxDrives> sources{};
  for (std::size_t i = kTracks; i < sources.size(); ++i) sources[i] = kFlipperSource;
  group_.set_drives(drives, {sources.data(), std::min(drives.size(), sources.size())});
}

Status UgvDrives::set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept {
  if (!std::isfinite(command.left_m_s) || !std::isfinite(command.right_m_s)) return Status::not_finite;
  const Status status =
      group_.say(kDriveSource, says(command.flags), command.asked, made_at(command.stamp_ns, now_ns), now_ns);
  if (status != Status::ok) return status;
  const bool enabled = (command.flags & rt::kCommandEnabled) != 0;
  wishes_[0] = enabled ? command.left_m_s * config_.per_m : 0.0;
  wishes_[1] = enabled ? command.right_m_s * config_.per_m : 0.0;
  return Status::ok;
}

Status UgvDrives::set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept {
  for (const double angle : command.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  if (!config_.flippers) return Status::ok;
  const Status status = group_.say(kFlipperSource, says(command.flags), command.asked,
                                   made_at(command.stamp_ns, now_ns), now_ns);
  if (status != Status::ok) return status;
  for (std::size_t i = 0; i < rt::kFlippers; ++i)
    wishes_[kTracks + i] = command.angle_rad[i] * config_.per_rad;
  return Status::ok;
}

void UgvDrives::decide(bool bus_works, std::span<const double> standing, rt::Nanoseconds now_ns) noexcept {
  const rt::Nanoseconds passed_ns =
      decided_ns_ < 0 ? 0 : std::clamp(now_ns - decided_ns_, rt::Nanoseconds{0}, kLongestStep);
  decided_ns_ = now_ns;
  const double passed_s = 1e-9 * static_cast<double>(passed_ns);
  const std::size_t count = std::min(standing.size(), kMaxDrives);
  std::array<double, kMaxDrives> targets{};
  for (std::size_t i = 0; i < count; ++i) {
    const bool track = i < kTracks;
    if (!group_.obeys(track ? kDriveSource : kFlipperSource, now_ns))
      soft_[i].begin(track ? 0.0 : standing[i]);
    const double most = passed_s * (track ? config_.soft_start_m_s2 * config_.per_m
                                          : config_.soft_start_rad_s * config_.per_rad);
    targets[i] = soft_[i].next(wishes_[i], most);
  }
  group_.decide(bus_works, {targets.data(), count}, now_ns);
}

}  // namespace sortie::drivers
