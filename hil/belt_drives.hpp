// SPDX-License-Identifier: BSD-3-Clause
// The drives of both belts: they follow the newest command while it is fresh, and ramp to zero when it is
// not.
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
};

/// Both belts. No heap, no clock: the owner tells the time.
class BeltDrives {
 public:
  /// `owner` begins the message of the std::runtime_error that names a setting which cannot be used.
  BeltDrives(const BeltDriveConfig& config, rt::Nanoseconds step_ns, const char* owner);

  /// A new command, received at `now_ns`. Bit 0 of its flags enables the drives. Status: ok, not_finite (the
  /// command before stays and ages).
  Status set(const rt::DriveCommand& command, rt::Nanoseconds now_ns);

  /// One step that ends at `now_ns`.
  void advance(rt::Nanoseconds now_ns);

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
  std::uint64_t commands_{};
  std::uint64_t stale_steps_{};
};

}  // namespace sortie::hil
