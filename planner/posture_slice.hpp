// SPDX-License-Identifier: BSD-3-Clause
// A slice of a tilted vehicle: its lower side over x, in level axes.
#pragma once

#include <algorithm>
#include <cmath>

#include "planner/posture_outline.hpp"

namespace sortie::planner {

inline constexpr double kWallShare = 0.94;  // sine of 70 degrees
inline constexpr double kWallSlope = 2.75;  // its tangent

/// A slice that is tilted: its lower side over x, in level axes.
struct TiltedSlice {
  double x[2], z[2], radius[2], y[2];  // discs from behind to ahead; y of their lowest points
  double run_x[2], run_z[2];           // ends of the lower run
  double squeeze;                      // of a disc's height: it is seen aslant
  double y_slope;
  double run_slope;

  TiltedSlice(const OutlineSlice& s, const Tilt& tilt) {
    const int rear = order(s, tilt);
    // A disc square to the axis a reaches r sqrt(1 - a_z^2) down.
    const double axis_z = tilt.roll.sin * tilt.pitch.cos;
    squeeze = std::sqrt(1.0 - axis_z * axis_z);
    const double down_x = tilt.pitch.sin;
    const double down_z = tilt.roll.cos * tilt.pitch.cos;
    const double first = -down_x * s.run_normal[0][0] + down_z * s.run_normal[0][1];
    const double second = -down_x * s.run_normal[1][0] + down_z * s.run_normal[1][1];
    const double* normal = first <= second ? s.run_normal[0] : s.run_normal[1];
    for (int k = 0; k < 2; ++k) {
      const int disc = k == 0 ? rear : 1 - rear;
      const double r = s.radius_m[disc];
      const rt::Vector3 centre = tilt.turn({s.x_m[disc], s.y_m, s.z_m[disc]});
      const rt::Vector3 end = tilt.turn({s.x_m[disc] + r * normal[0], s.y_m, s.z_m[disc] + r * normal[1]});
      x[k] = centre.x;
      z[k] = centre.z;
      y[k] = centre.y + r * tilt.roll.sin;
      radius[k] = r;
      run_x[k] = end.x;
      run_z[k] = end.z;
    }
    const double apart = x[1] - x[0];
    y_slope = apart > 1e-3 ? (y[1] - y[0]) / apart : 0.0;
    const double run = run_x[1] - run_x[0];
    run_slope = run > 1e-9 ? (run_z[1] - run_z[0]) / run : 1e9;
  }

  static int order(const OutlineSlice& s, const Tilt& tilt) {
    const double ahead =
        (s.x_m[1] - s.x_m[0]) * tilt.pitch.cos + (s.z_m[1] - s.z_m[0]) * tilt.roll.cos * tilt.pitch.sin;
    return ahead >= 0.0 ? 0 : 1;
  }

  double begin() const { return std::min(run_x[0], x[0] - kWallShare * radius[0]); }
  double end() const { return std::max(run_x[1], x[1] + kWallShare * radius[1]); }
  double y_at(double at) const { return y[0] + y_slope * (std::clamp(at, x[0], x[1]) - x[0]); }

  /// Its lower side at x. False beside a wall.
  bool bottom(double at, double& height) const {
    if (at >= run_x[0] && at <= run_x[1]) {
      if (std::fabs(run_slope) > kWallSlope) return false;
      height = run_z[0] + run_slope * (at - run_x[0]);
      return true;
    }
    const int k = at < run_x[0] ? 0 : 1;
    const double off = at - x[k];
    if (std::fabs(off) > kWallShare * radius[k]) return false;
    height = z[k] - squeeze * std::sqrt(radius[k] * radius[k] - off * off);
    return true;
  }
};

}  // namespace sortie::planner
