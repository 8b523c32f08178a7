// SPDX-License-Identifier: BSD-3-Clause
// The drives of both belts: they follow the newest command while it is fresh, and ramp to zero when it is
// not. A belt without torque coasts.
#pragma once

#include <cstdint>

#include "hil/track_drive.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"

namespace sortie::hil {

/// What the drives can do.
struct BeltDriveConfig {
  double speed_lag_s{0.08};           ///< time constant
  double max_speed_m_s{0.6};          ///< commands beyond it are limited
  double max_acceleration_m_s2{2.0};  ///< of a belt
  double command_timeout_s{0.2};      ///< without a fresh command the belts ramp to zero
  double coast_friction_m_s2{0.6};    ///< what slows a belt without torque
};

/// Both belts. No heap, no clock: the owner tells the time.
class BeltDrives {
 public:
  /// Throws std::runtime_error "hil <owner>: ..." with the setting that cannot be used.
  BeltDrives(const BeltDriveConfig& config, rt::Nanoseconds step_ns, const char* owner);

  /// A new command, received at `now_ns`. Bit 0 of its flags enables the drives. Status: ok, not_finite (the
  /// command before stays and ages).
  Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns);

  /// Which belts have no torque from now on: they coast.
  void let_go(bool left, bool right) {
    left_free_ = left;
    right_free_ = right;
  }

  /// One step that ends at `now_ns`. `push_m_s2`: of gravity, ahead.
  void advance(rt::Nanoseconds now_ns, double push_m_s2);

  const TrackDrive& left() const { return left_; }
  const TrackDrive& right() const { return right_; }
  std::uint64_t commands() const { return commands_; }        ///< taken
  std::uint64_t stale_steps() const { return stale_steps_; }  ///< steps with an outdated command

 private:
  double max_speed_m_s_;
  rt::Nanoseconds timeout_ns_;
  TrackDrive left_;
  TrackDrive right_;
  rt::DriveCommand command_{};
  rt::Nanoseconds command_ns_{};
  bool commanded_{};
  bool left_free_{};
  bool right_free_{};
  double friction_m_s2_;
  std::uint64_t commands_{};
  std::uint64_t stale_steps_{};
};

}  // namespace sortie::hil
