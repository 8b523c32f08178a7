// SPDX-License-Identifier: BSD-3-Clause
// Places ahead on the arc that a vehicle is asked to drive.
#pragma once

#include <cmath>

#include "planner/posture_ground.hpp"
#include "rt/math.hpp"

namespace sortie::planner {

/// A speed and a turn rate, held.
struct WantedArc {
  double speed_m_s{};   ///< backward below 0
  double turn_rad_s{};  ///< to the left above 0
  bool still() const { return speed_m_s == 0.0 && turn_rad_s == 0.0; }
};

inline constexpr int kArcPlaces = 4;

/// How far each place is along the arc. The first is where the vehicle is, the second is near.
inline constexpr double kArcAhead_m[kArcPlaces] = {0.0, 0.1, 0.25, 0.45};

/// The place `ahead_m` along the arc. A turn counts with what a point 0.3 m off the middle would go, so that
/// turning on the spot has places, too. Mirrored pose and arc give the mirrored place to the last bit. Speed
/// and turn must be finite and not both 0.
inline StandPose arc_place(const StandPose& from, const WantedArc& arc, double ahead_m) {
  constexpr double kLever_m = 0.3;
  const double t = ahead_m / (std::fabs(arc.speed_m_s) + kLever_m * std::fabs(arc.turn_rad_s));
  const double way = arc.speed_m_s * t;
  const double turned = arc.turn_rad_s * t;
  // The chord of an arc: it leaves at half of the turn, and is shorter than the arc by sin(h) / h.
  const double half = 0.5 * turned;
  const rt::SinCos to = rt::sincos(from.yaw_rad + half);
  const double chord = std::fabs(half) < 1e-6 ? way : way * (rt::sin(half) / half);
  return {from.x_m + chord * to.cos, from.y_m + chord * to.sin, from.yaw_rad + turned};
}

}  // namespace sortie::planner
