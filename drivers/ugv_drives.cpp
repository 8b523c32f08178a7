// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/ugv_drives.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::drivers {
namespace {

// A pause is not made up for at once.
constexpr rt::Nanoseconds kLongestStep = 20 * rt::kNanosecondsPerMillisecond;

// When a run begins while somebody already asks for speed, or for an angle far away: how fast targets go
// there. From then on they are followed as they come.
constexpr double kSoftStart_m_s2 = 2.0;
constexpr double kSoftStart_rad_s = 1.0;

// Torque through whatever makes the robot wait: what is wanted and not enabled holds.
bool is_on(std::uint32_t flags) { return (flags & (rt::kCommandEnabled | rt::kCommandWanted)) != 0; }
rt::Nanoseconds made_at(rt::Nanoseconds stamp_ns, rt::Nanoseconds now_ns) {
  return stamp_ns == 0 ? now_ns : stamp_ns;
}

}  // namespace

UgvDrives::UgvDrives(const DriveGroupConfig& group, bool flippers, double per_m, double per_rad)
    : flippers_(flippers), per_m_(per_m), per_rad_(per_rad), group_(group) {}

void UgvDrives::attach(std::span<MotorDrive* const> drives) {
  std::array<std::uint8_t, kMaxDrives> sources{};
  for (std::size_t i = kTracks; i < sources.size(); ++i) sources[i] = kFlipperSource;
  group_.set_drives(drives, {sources.data(), std::min(drives.size(), sources.size())});
}

Status UgvDrives::set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept {
  if (!std::isfinite(command.left_m_s) || !std::isfinite(command.right_m_s)) return Status::not_finite;
  const Status status = group_.say(kDriveSource, is_on(command.flags), command.asked,
                                   made_at(command.stamp_ns, now_ns), now_ns);
  if (status != Status::ok) return status;
  const bool enabled = (command.flags & rt::kCommandEnabled) != 0;
  wishes_[0] = enabled ? command.left_m_s * per_m_ : 0.0;
  wishes_[1] = enabled ? command.right_m_s * per_m_ : 0.0;
  return Status::ok;
}

Status UgvDrives::set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept {
  for (const double angle : command.angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  if (!flippers_) return Status::ok;
  const Status status = group_.say(kFlipperSource, is_on(command.flags), command.asked,
                                   made_at(command.stamp_ns, now_ns), now_ns);
  if (status != Status::ok) return status;
  for (std::size_t i = 0; i < rt::kFlippers; ++i) wishes_[kTracks + i] = command.angle_rad[i] * per_rad_;
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
    SoftTarget& soft = soft_[i];
    if (!group_.obeys(track ? kDriveSource : kFlipperSource, now_ns)) soft = {track ? 0.0 : standing[i]};
    targets[i] = wishes_[i];
    if (!soft.joins) continue;
    const double most = passed_s * (track ? kSoftStart_m_s2 * per_m_ : kSoftStart_rad_s * per_rad_);
    soft.value += std::clamp(wishes_[i] - soft.value, -most, most);
    soft.joins = soft.value != wishes_[i];
    targets[i] = soft.value;
  }
  group_.decide(bus_works, {targets.data(), count}, now_ns);
}

}  // namespace sortie::drivers
