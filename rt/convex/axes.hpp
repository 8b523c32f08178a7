// SPDX-License-Identifier: BSD-3-Clause
// The directions along which two bodies can lie apart, tried one after the other.
//
// For a direction d (unit, from b into a) the overlap is f(d) = max over b of d.x - min over a of d.x. A
// negative overlap proves a gap of that size; the penetration depth is the smallest overlap of all
// directions. For polyhedra that smallest one is a face normal or a product of two edges (Gottschalk, Lin,
// Manocha 1996); for a wheel against an edge it points from the edge to the wheel's axis.
#pragma once

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// A direction from b into a, and how far the bodies overlap along it.
struct Axis {
  Vector3 direction{0, 0, 1};
  double overlap_m{1e300};
};

/// The overlap of the bodies along a unit direction. 20-30 ns.
double overlap_along(const Convex& a, const Convex& b, const Vector3& direction);

/// Keeps the direction of the smallest overlap.
class AxisSearch {
 public:
  /// Axes with an overlap below `-margin_m` end the search; `face_preference_m`: see ManifoldOptions.
  AxisSearch(const Convex& a, const Convex& b, double margin_m, double face_preference_m)
      : a_(a), b_(b), margin_m_(margin_m), preference_m_(face_preference_m) {}

  /// Tries one direction (unit). True when it proves a gap wider than the margin.
  bool consider(const Vector3& direction, double handicap_m = 0.0);

  /// Tries the middles' line, the faces, the products of edges, and wheels against corners. True when one of
  /// them proves a gap wider than the margin; then it is best(). At most 40 directions.
  bool consider_all();

  const Axis& best() const { return best_; }
  /// How much less overlap another direction, with the handicap given, must have to become best().
  double lead_m(double handicap_m) const { return handicap_m - (handicapped_m_ - best_.overlap_m); }

 private:
  bool consider_faces(const Convex& body, double sign);
  bool consider_edges();
  bool consider_wheels(const Convex& track, const Convex& box, double sign);
  bool consider_both(const Vector3& direction, double handicap_m);
  bool judge(const Vector3& direction, double overlap_m, double handicap_m);

  const Convex& a_;
  const Convex& b_;
  double margin_m_;
  double preference_m_;
  double handicapped_m_{1e300};
  Axis best_{};
};

}  // namespace sortie::rt::convex
