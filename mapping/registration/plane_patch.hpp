// SPDX-License-Identifier: BSD-3-Clause
// Whether two bounded planes cover a common part, seen along the normal of one of them.
#pragma once

#include <cmath>

#include "mapping/registration/plane.hpp"

namespace sortie::mapping {

/// A parallelogram in the (u, v) coordinates of some plane: its centre and half of two sides.
struct PlanePatch {
  double centre[2]{};
  double a[2]{};
  double b[2]{};
};

/// A plane's own rectangle in its own coordinates, from its centroid.
constexpr PlanePatch own_patch(const Plane& plane) {
  return {{0.5 * (plane.least_m[0] + plane.most_m[0]), 0.5 * (plane.least_m[1] + plane.most_m[1])},
          {0.5 * (plane.most_m[0] - plane.least_m[0]), 0},
          {0, 0.5 * (plane.most_m[1] - plane.least_m[1])}};
}

/// A rectangle with middle `p` and half sides `a` and `b` (in the frame of `onto`), projected onto that plane.
constexpr PlanePatch projected(const Plane& onto, const rt::Vector3& p, const rt::Vector3& a,
                               const rt::Vector3& b) {
  const rt::Vector3 u = onto.axis_u;
  const rt::Vector3 v = onto.axis_v();
  const rt::Vector3 d = p - onto.centroid_m;
  return {{rt::dot(d, u), rt::dot(d, v)}, {rt::dot(a, u), rt::dot(a, v)}, {rt::dot(b, u), rt::dot(b, v)}};
}

/// True where one of the two directions square to the sides of `p` keeps the patches more than `margin_m`
/// apart.
inline bool separated_by(const PlanePatch& p, const PlanePatch& q, double margin_m) {
  const double d[2] = {q.centre[0] - p.centre[0], q.centre[1] - p.centre[1]};
  const auto along = [](const double (&n)[2], const double (&e)[2]) { return n[0] * e[0] + n[1] * e[1]; };
  const double normals[2][2] = {{-p.a[1], p.a[0]}, {-p.b[1], p.b[0]}};
  for (const auto& n : normals) {
    const double reach = std::fabs(along(n, p.a)) + std::fabs(along(n, p.b)) + std::fabs(along(n, q.a)) +
                         std::fabs(along(n, q.b));
    const double distance = std::fabs(along(n, d));
    // n is as long as the side: margin and distance are compared in its length; the root only where it counts.
    if (distance > reach && distance > reach + margin_m * std::sqrt(along(n, n))) return true;
  }
  return false;
}

/// Separating axes of two parallelograms: exact, as convex figures that do not meet are kept apart by a
/// direction square to one of their sides. Patches less than `margin_m` apart along all four count as
/// overlapping, and so do all where a side has no length. The same answer for (p, q) and (q, p). ~40 ns.
inline bool overlap(const PlanePatch& p, const PlanePatch& q, double margin_m) {
  return !separated_by(p, q, margin_m) && !separated_by(q, p, margin_m);
}

}  // namespace sortie::mapping
