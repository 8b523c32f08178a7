// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/axes.hpp"

#include "rt/convex/local.hpp"
#include "rt/convex/support.hpp"

namespace sortie::rt::convex {
namespace {

// Outward normals of flat faces whose opposites are none.
int runs_of(const Convex& body, Vector3 (&normals)[2]) {
  if (body.kind != Kind::track || body.length_m == 0.0) return 0;
  normals[0] = body.R_world_body * Vector3{body.run_normal[0], 0.0, body.run_normal[1]};
  normals[1] = body.R_world_body * Vector3{body.run_normal[0], 0.0, -body.run_normal[1]};
  return 2;
}

// Directions of straight edges, and of the straight lines on round parts.
int edges_of(const Convex& body, Vector3 (&edges)[3]) {
  switch (body.kind) {
    case Kind::box:
      for (int i = 0; i < 3; ++i) edges[i] = axis_of(body, i);
      return 3;
    case Kind::track:
      edges[0] = axis_of(body, 1);
      if (body.length_m == 0.0) return 1;
      edges[1] = body.R_world_body * Vector3{body.run_normal[1], 0.0, -body.run_normal[0]};
      edges[2] = body.R_world_body * Vector3{body.run_normal[1], 0.0, body.run_normal[0]};
      return 3;
    case Kind::swept_ellipsoid:
      return normalise(body.R_world_body * body.sweep_m, edges[0]) ? 1 : 0;
    case Kind::none:
      break;
  }
  return 0;
}

}  // namespace

double overlap_along(const Convex& a, const Convex& b, const Vector3& direction) {
  return reach(b, direction, b.p_world_m) + reach(a, -1.0 * direction, b.p_world_m);
}

bool AxisSearch::consider(const Vector3& direction, double handicap_m) {
  return judge(direction, overlap_along(a_, b_, direction), handicap_m);
}

bool AxisSearch::judge(const Vector3& direction, double overlap_m, double handicap_m) {
  if (overlap_m + handicap_m < handicapped_m_) {
    handicapped_m_ = overlap_m + handicap_m;
    best_ = {direction, overlap_m};
  }
  if (overlap_m < -margin_m_) {
    best_ = {direction, overlap_m};
    return true;
  }
  return false;
}

bool AxisSearch::consider_both(const Vector3& direction, double handicap_m) {
  const Reach of_a = reach_both(a_, direction, b_.p_world_m);
  const Reach of_b = reach_both(b_, direction, b_.p_world_m);
  return judge(direction, of_b.ahead_m + of_a.behind_m, handicap_m) ||
         judge(-1.0 * direction, of_b.behind_m + of_a.ahead_m, handicap_m);
}

bool AxisSearch::consider_faces(const Convex& body, double sign) {
  if (body.kind == Kind::box) {
    for (int i = 0; i < 3; ++i) {
      if (consider_both(axis_of(body, i), 0.0)) return true;
    }
  } else if (body.kind == Kind::track) {
    if (consider_both(axis_of(body, 1), 0.0)) return true;
  }
  Vector3 normals[2];
  const int count = runs_of(body, normals);
  for (int i = 0; i < count; ++i) {
    if (consider(sign * normals[i], 0.0)) return true;
  }
  return false;
}

bool AxisSearch::consider_edges() {
  Vector3 of_a[3];
  Vector3 of_b[3];
  const int count_a = edges_of(a_, of_a);
  const int count_b = edges_of(b_, of_b);
  for (int i = 0; i < count_a; ++i) {
    for (int k = 0; k < count_b; ++k) {
      Vector3 direction;
      // Edges as good as parallel have no product; a face normal covers them.
      if (normalise(cross(of_a[i], of_b[k]), direction) && consider_both(direction, preference_m_))
        return true;
    }
  }
  return false;
}

// In the plane of the wheels: from the corner nearest to a wheel's axis to that axis. A contact of a wheel
// with an edge that is parallel to the axis is exact then.
bool AxisSearch::consider_wheels(const Convex& track, const Convex& box, double sign) {
  const Vector3 between = box.p_world_m - track.p_world_m;
  const Vector3 c = to_body(track, between);
  double ex[3];
  double ez[3];
  const double half[3] = {box.half_m.x, box.half_m.y, box.half_m.z};
  for (int i = 0; i < 3; ++i) {
    const Vector3 e = to_body(track, axis_of(box, i));
    ex[i] = half[i] * e.x;
    ez[i] = half[i] * e.z;
  }
  for (int wheel = 0; wheel < (track.length_m == 0.0 ? 1 : 2); ++wheel) {
    const double wheel_x = track.first_x_m + (wheel == 1 ? track.length_m : 0.0);
    double nearest = 1e300;
    Vector3 away{};
    for (unsigned corner = 0; corner < 8; ++corner) {
      double x = wheel_x - c.x;
      double z = -c.z;
      for (unsigned i = 0; i < 3; ++i) {
        const bool negative = ((corner >> i) & 1u) != 0;
        x += negative ? ex[i] : -ex[i];
        z += negative ? ez[i] : -ez[i];
      }
      const double distance2 = x * x + z * z;
      if (distance2 < nearest) {
        nearest = distance2;
        away = {x, 0.0, z};
      }
    }
    Vector3 direction;
    if (normalise(track.R_world_body * away, direction) && consider(sign * direction, preference_m_))
      return true;
  }
  return false;
}

bool AxisSearch::consider_all() {
  Vector3 line;
  if (normalise(middle(a_) - middle(b_), line) && overlap_along(a_, b_, line) < -margin_m_) {
    return consider(line);  // most pairs end here; as a normal it is no candidate
  }
  if (consider_faces(b_, 1.0) || consider_faces(a_, -1.0) || consider_edges()) return true;
  if (a_.kind == Kind::track && b_.kind == Kind::box) return consider_wheels(a_, b_, 1.0);
  if (a_.kind == Kind::box && b_.kind == Kind::track) return consider_wheels(b_, a_, -1.0);
  if (best_.overlap_m > 1e299)
    return consider(normalise(middle(a_) - middle(b_), line) ? line : Vector3{0, 0, 1});
  return false;
}

}  // namespace sortie::rt::convex
