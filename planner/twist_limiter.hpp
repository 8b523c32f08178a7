// SPDX-License-Identifier: BSD-3-Clause
// Speed and turn rate of the body within all limits of body and tracks at once.
#pragma once

#include "planner/jerk_limiter.hpp"
#include "rt/archive.hpp"

namespace sortie::planner {

/// What speed and turn rate must stay within. All above 0.
struct TwistLimits {
  double max_speed_m_s{0.5};
  double max_turn_rad_s{1.0};
  double max_track_m_s{0.6};  ///< of either belt
  double lever_m{0.2};        ///< belt speed per turn rate (IcrModel::lever_m)
};

/// How fast they may change.
struct TwistRamps {
  RampLimits speed{0.5, 5.0};  ///< m/s^2, m/s^3
  RampLimits turn{3.0, 30.0};  ///< rad/s^2, rad/s^3
};

/// Speed and turn rate that belong together.
struct SpeedTurn {
  double speed_m_s{};
  double turn_rad_s{};
  SORTIE_FIELDS(speed_m_s, turn_rad_s)
};

/// `wish` shortened, if it must be, until it fits: both parts by the same factor, so that the curvature stays
/// what was asked for.
SpeedTurn fit(const SpeedTurn& wish, const TwistLimits& limits);

/// Leads speed and turn rate to a set-point. At every step, whatever the set-points do, as long as the limits
/// stay what they are: |speed|, |turn|, |speed| + lever |turn| (and with it either belt), both accelerations
/// and both jerks within their limits; no set-point is passed unless it moved back. From rest, to rest at
/// constant speed, and wherever else both axes can, the two ramps last equally long, so that the curvature is
/// kept on the way, too. 32 bytes, no heap, about 50 ns a step.
class TwistLimiter {
 public:
  /// One step of `dt_s` toward `wish` (finite), which is fitted first. The same dt_s each time.
  void step(const SpeedTurn& wish, const TwistLimits& limits, const TwistRamps& ramps, double dt_s);

  SpeedTurn now() const { return {speed_.value, turn_.value}; }
  const JerkLimiter& speed() const { return speed_; }
  const JerkLimiter& turn() const { return turn_; }
  /// True when nothing moves and nothing is about to.
  bool at_rest() const {
    return speed_.value == 0.0 && speed_.rate == 0.0 && turn_.value == 0.0 && turn_.rate == 0.0;
  }

  void archive(rt::Archive& archive) { rt::Members(archive, *this, "twist limiter").state(speed_, turn_); }

 private:
  JerkLimiter speed_;
  JerkLimiter turn_;
};

}  // namespace sortie::planner
