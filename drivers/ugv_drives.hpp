// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's drives behind whatever protocol they speak: commands in, samples out, in the units of
// the rest of the program. Two sources of commands, each with an age of its own, one group that runs or stops
// all, and targets that do not step when a run begins.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "drivers/can_bus.hpp"
#include "drivers/drive_group.hpp"
#include "rt/keys.hpp"
#include "rt/samples.hpp"

namespace sortie::drivers {

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

/// Two tracks and up to four flippers. Every source of commands (tracks, flippers) that has enabled its
/// motors must go on saying so: one that falls silent stops all, and no other's commands renew it. A command
/// that cannot be used renews nothing. One thread; no call waits, throws or takes memory. What a user calls
/// is virtual, so that a program without such motors has none of their code.
class UgvDrives {
 public:
  virtual ~UgvDrives() = default;

  /// New commands; the motors run while either is enabled. Speeds and angles that the motors' numbers cannot
  /// hold are limited. Status: ok; not_finite (the command before stays, and ages); stale, time_backwards (by
  /// the command's stamp; 0: made now).
  [[nodiscard]] virtual Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns) noexcept;
  [[nodiscard]] virtual Status set(const rt::FlipperCommand& command, rt::Nanoseconds now_ns) noexcept;

  /// The emergency stop. While it is pressed all motors stop and then have no torque; what was asked for is
  /// forgotten, so that nothing runs after its release until it is asked anew.
  virtual void press(bool pressed) noexcept { group_.press(pressed); }
  virtual bool pressed() const noexcept { return group_.pressed(); }

  /// Takes a frame; true: it was a motor's.
  virtual bool take(const CanFrame& frame, rt::Nanoseconds now_ns) noexcept = 0;
  /// Sends what is due. At least once a millisecond.
  virtual void poll(rt::Nanoseconds now_ns, CanBus& bus) noexcept = 0;

  /// What both tracks (all flippers) showed at one moment. Status: ok; empty: nothing new.
  [[nodiscard]] virtual Status read(rt::TrackSample& sample) noexcept = 0;
  [[nodiscard]] virtual Status read(rt::FlipperSample& sample) noexcept = 0;

  virtual bool running() const noexcept { return group_.running(); }
  virtual StopReason stop_reason() const noexcept { return group_.reason(); }
  const DriveGroup& group() const noexcept { return group_; }

 protected:
  /// `per_m`, `per_rad`: units of a track's drive in a metre, of a flipper's in a radian.
  UgvDrives(const DriveGroupConfig& group, bool flippers, double per_m, double per_rad);
  /// Set-up: the drives, tracks first, then flippers.
  void attach(std::span<MotorDrive* const> drives);
  /// Once a poll: what all are to do. `standing`: where each drive is, in its units.
  void decide(bool bus_works, std::span<const double> standing, rt::Nanoseconds now_ns) noexcept;

 private:
  static constexpr std::size_t kDriveSource = 0;
  static constexpr std::size_t kFlipperSource = 1;

  /// Begins where the motor is, and goes to what is asked for at a limited rate, until it has caught up.
  struct SoftTarget {
    double value{};
    bool joins{true};
  };

  bool flippers_;
  double per_m_;
  double per_rad_;
  DriveGroup group_;
  std::array<double, kMaxDrives> wishes_{};
  std::array<SoftTarget, kMaxDrives> soft_{};
  rt::Nanoseconds decided_ns_{-1};
};

}  // namespace sortie::drivers
