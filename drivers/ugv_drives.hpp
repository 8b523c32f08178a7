// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drives, whatever their protocol: two sources of commands, each with an age of its own,
// one group that runs or stops all, and targets that do not step when a run begins.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/drive_group.hpp"
#include "drivers/soft_target.hpp"
#include "drivers/ugv_motors.hpp"
#include "rt/keys.hpp"

namespace sortie::drivers {

/// What all protocols share.
struct UgvDrivesConfig {
  DriveGroupConfig group{};
  bool flippers = true;
  double per_m = 1.0;    ///< units of a track's drive in a metre
  double per_rad = 1.0;  ///< of a flipper's in a radian
  /// When a run begins while somebody already asks for speed, or for an angle far away: how fast targets go
  /// there. From then on they are followed as they come.
  double soft_start_m_s2 = 2.0;
  double soft_start_rad_s = 1.0;
};

/// Keys of every protocol's config `c`, which calls its cycle and its silence by names of its own.
template <class Config, class Span, class Key>
constexpr void shared_drive_keys(Config& c, Span& cycle_ns, Span& silence_ns, Key&& key) {
  constexpr rt::KeySpec kNode{1, 127, "", "number of this drive on the bus"};
  key("node_left", c.track_nodes[0], kNode);
  key("node_right", c.track_nodes[1], kNode);
  key("node_front_left", c.flipper_nodes[0], kNode);
  key("node_front_right", c.flipper_nodes[1], kNode);
  key("node_rear_left", c.flipper_nodes[2], kNode);
  key("node_rear_right", c.flipper_nodes[3], kNode);
  key("sync_ms", cycle_ns, {1, 255, rt::kMsInNs, "between commands, whole ms"});
  key("heartbeat_timeout_ms", silence_ns,
      {1, 60'000, rt::kMsInNs, "silence after which a drive stops by itself, or counts as lost, whole ms"});
  DriveGroupConfig::keys(c.group, key);
}

/// Tracks come first among the drives, flippers behind them.
inline constexpr std::size_t kTracks = 2;

/// Commands and their ages. Every source (tracks, flippers) that has enabled its motors must go on saying so:
/// one that falls silent stops all, and no other's commands renew it. A command that cannot be used renews
/// nothing.
class UgvDrives : public UgvMotors {
 public:
  /// As UgvMotors; also stale, time_backwards: by the command's stamp (0: made now).
  [[nodiscard]] Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept final;
  [[nodiscard]] Status set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept final;
  void press(bool pressed) noexcept final { group_.press(pressed); }
  bool pressed() const noexcept final { return group_.pressed(); }

  bool running() const noexcept final { return group_.running(); }
  StopReason stop_reason() const noexcept final { return group_.reason(); }
  const DriveGroup& group() const noexcept { return group_; }

 protected:
  /// Throws std::runtime_error where a setting cannot be used.
  explicit UgvDrives(const UgvDrivesConfig& config);
  /// Set-up: the drives, tracks first, then flippers.
  void attach(std::span<MotorDrive* const> drives);
  /// Once a poll: what all are to do. `standing`: where each drive is, in its units.
  void decide(bool bus_works, std::span<const double> standing, rt::Nanoseconds now_ns) noexcept;

 private:
  static constexpr std::size_t kDriveSource = 0;
  static constexpr std::size_t kFlipperSource = 1;

  UgvDrivesConfig config_;
  DriveGroup group_;
  std::array<double, kMaxDrives> wishes_{};
  std::array<SoftTarget, kMaxDrives> soft_{};
  rt::Nanoseconds decided_ns_{-1};
};

}  // namespace sortie::drivers
