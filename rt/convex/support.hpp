// SPDX-License-Identifier: BSD-3-Clause
// What collision checks ask of a body: its outermost point in a direction, how far it reaches, its bounds,
// whether a point is inside. All directions and points are in the world frame. No heap, no loop beyond 3.
#pragma once

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// The outermost point of the body in direction `dir_world` (any length). For a zero direction or a NaN: a
/// point of the body all the same. Where a whole edge or face is outermost, one of its corners. 10-20 ns.
Vector3 support(const Convex& body, const Vector3& dir_world);

/// The largest `dir_world . (x - reference)` over the body's points x: support() without the point. The
/// reference keeps digits far from the origin. Exact to rounding; about half the price of support().
double reach(const Convex& body, const Vector3& dir_world, const Vector3& reference_world_m);

/// reach() along a direction and against it.
struct Reach {
  double ahead_m{};
  double behind_m{};
};

/// Both at little more than the price of one, to the same bits.
Reach reach_both(const Convex& body, const Vector3& dir_world, const Vector3& reference_world_m);

/// The body's middle, in the world.
Vector3 middle(const Convex& body);

/// A point well inside the body, not far from `towards_world_m`.
Vector3 inside_near(const Convex& body, const Vector3& towards_world_m);

/// The smallest of the body's half thicknesses and radii.
double thickness(const Convex& body);

/// A box with edges along the world's axes.
struct Bounds {
  Vector3 low_m{};
  Vector3 high_m{};
};

/// The smallest such box around the body.
Bounds bounds(const Convex& body);

/// True when the two share a point.
constexpr bool overlap(const Bounds& a, const Bounds& b) {
  return a.low_m.x <= b.high_m.x && b.low_m.x <= a.high_m.x && a.low_m.y <= b.high_m.y &&
         b.low_m.y <= a.high_m.y && a.low_m.z <= b.high_m.z && b.low_m.z <= a.high_m.z;
}

/// True when the point is in the body or on its surface, to rounding.
bool contains(const Convex& body, const Vector3& point_world_m);

}  // namespace sortie::rt::convex
