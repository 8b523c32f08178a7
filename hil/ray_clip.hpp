// SPDX-License-Identifier: BSD-3-Clause
// The part of a ray that lies in a convex solid, face by face. Internal to the solids.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "hil/solid.hpp"

namespace sortie::hil {

// Below it a component of a unit direction is 0: its inverse would overflow, and 0 * infinity is NaN.
inline constexpr double kParallel = 1e-150;

/// The part of a ray that is inside of all half-spaces seen so far, and the face it entered by.
struct Clip {
  double near_m{-std::numeric_limits<double>::infinity()};
  double far_m{std::numeric_limits<double>::infinity()};
  Vec3 normal{};
  bool empty{};

  /// Keeps what satisfies value + slope * t <= 0; `outward` is the normal of that face.
  void half_space(double value, double slope, const Vec3& outward) {
    if (std::fabs(slope) < kParallel) {
      empty = empty || value > 0.0;
      return;
    }
    const double t = -value / slope;
    if (slope < 0.0) {
      if (t > near_m) {
        near_m = t;
        normal = outward;
      }
    } else {
      far_m = std::min(far_m, t);
    }
  }

  /// Keeps what satisfies |origin + direction * t| <= half along one axis.
  void slab(double origin, double direction, double half, const Vec3& axis) {
    if (std::fabs(direction) < kParallel) {
      empty = empty || std::fabs(origin) > half;
      return;
    }
    const double inverse = 1.0 / direction;
    const double reach = half * std::fabs(inverse);
    const double middle = -origin * inverse;
    if (middle - reach > near_m) {
      near_m = middle - reach;
      normal = direction > 0.0 ? -1.0 * axis : axis;
    }
    far_m = std::min(far_m, middle + reach);
  }

  bool missed() const { return empty || near_m > far_m || far_m < 0.0; }
};

struct Local {
  double x;
  double y;
};

/// Keeps what is within `radius` of the origin of the plane, in which the normal lies: a round wall.
inline void clip_round(Clip& clip, const Local& o, const Local& d, double radius) {
  const double a = d.x * d.x + d.y * d.y;
  const double c = o.x * o.x + o.y * o.y - radius * radius;
  if (a < kParallel) {
    clip.empty = clip.empty || c > 0.0;
    return;
  }
  const double b = o.x * d.x + o.y * d.y;
  // The discriminant from the distance of the line to the axis: b*b - a*c cancels for far origins.
  const double moment = o.x * d.y - o.y * d.x;
  const double discriminant = a * radius * radius - moment * moment;
  if (discriminant < 0.0) {
    clip.empty = true;
    return;
  }
  const double root = std::sqrt(discriminant);
  // Both roots without the cancellation of -b +- root.
  const double q = b > 0.0 ? -b - root : -b + root;
  const double first = q / a;
  const double second = q == 0.0 ? 0.0 : c / q;
  const double enter = std::min(first, second);
  if (enter > clip.near_m) {
    clip.near_m = enter;
    const double inverse_radius = 1.0 / radius;
    clip.normal = {(o.x + enter * d.x) * inverse_radius, (o.y + enter * d.y) * inverse_radius, 0.0};
  }
  clip.far_m = std::min(clip.far_m, std::max(first, second));
}

/// The same about the y axis: x stays x, and z becomes the y of clip_round(). The normal is one of space.
inline void clip_wheel(Clip& clip, const Vec3& o, const Vec3& d, double radius) {
  Clip round;
  clip_round(round, {o.x, o.z}, {d.x, d.z}, radius);
  clip.empty = clip.empty || round.empty;
  clip.far_m = std::min(clip.far_m, round.far_m);
  if (round.near_m > clip.near_m) {
    clip.near_m = round.near_m;
    clip.normal = {round.normal.x, 0.0, round.normal.y};
  }
}

/// Tilted solids, for intersect().
Contact intersect_tilted(const Ray& ray, const Solid& solid);

}  // namespace sortie::hil
