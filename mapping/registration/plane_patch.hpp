// SPDX-License-Identifier: BSD-3-Clause
// Whether two bounded planes cover a common part, seen along the normal of one of them.
#pragma once

#include <algorithm>
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

/// A rectangle with middle `p` and half sides `a` and `b` (in the frame of `onto`), projected onto that
/// plane.
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
  const auto along = [](const double(&n)[2], const double(&e)[2]) { return n[0] * e[0] + n[1] * e[1]; };
  const double normals[2][2] = {{-p.a[1], p.a[0]}, {-p.b[1], p.b[0]}};
  for (const auto& n : normals) {
    const double reach = std::fabs(along(n, p.a)) + std::fabs(along(n, p.b)) + std::fabs(along(n, q.a)) +
                         std::fabs(along(n, q.b));
    const double distance = std::fabs(along(n, d));
    // n is as long as the side: margin and distance are compared in its length; the root only where it
    // counts.
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

/// Area of a patch [m2].
inline double area_of(const PlanePatch& p) { return 4.0 * std::fabs(p.a[0] * p.b[1] - p.a[1] * p.b[0]); }

/// Area that a patch has in common with a plane's own rectangle [m2]: the patch's corners, cut at the
/// rectangle's four sides (I. Sutherland, G. Hodgman 1974). ~0.1 us.
inline double common_area(const PlanePatch& own, const PlanePatch& patch) {
  constexpr int kMost = 8;  // four corners, and one more at each cut
  double corner[kMost][2];
  int count = 4;
  const double signs[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 2; ++i)
      corner[k][i] = patch.centre[i] - own.centre[i] + signs[k][0] * patch.a[i] + signs[k][1] * patch.b[i];
  }
  const double half[2] = {own.a[0], own.b[1]};
  for (int side = 0; side < 4 && count > 0; ++side) {
    const int axis = side / 2;
    const double sign = side % 2 == 0 ? 1.0 : -1.0;
    double kept[kMost][2];
    int kept_count = 0;
    for (int k = 0; k < count; ++k) {
      const double(&p)[2] = corner[k];
      const double(&q)[2] = corner[(k + 1) % count];
      const double in_p = half[axis] - sign * p[axis];
      const double in_q = half[axis] - sign * q[axis];
      if (in_p >= 0.0 && kept_count < kMost) {
        kept[kept_count][0] = p[0];
        kept[kept_count++][1] = p[1];
      }
      if (((in_p > 0.0 && in_q < 0.0) || (in_p < 0.0 && in_q > 0.0)) && kept_count < kMost) {
        const double t = in_p / (in_p - in_q);
        kept[kept_count][0] = p[0] + t * (q[0] - p[0]);
        kept[kept_count++][1] = p[1] + t * (q[1] - p[1]);
      }
    }
    count = kept_count;
    for (int k = 0; k < count; ++k) std::copy_n(kept[k], 2, corner[k]);
  }
  double twice = 0.0;
  for (int k = 0; k < count; ++k) {
    const double(&p)[2] = corner[k];
    const double(&q)[2] = corner[(k + 1) % count];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return 0.5 * std::fabs(twice);
}

}  // namespace sortie::mapping
