// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/shape.hpp"

#include <cmath>

namespace sortie::rt::convex {
namespace {

bool is_size(double x) { return x > 0.0 && std::isfinite(x); }

}  // namespace

Convex make_box(const Vector3& half_m) {
  Convex body;
  if (!is_size(half_m.x) || !is_size(half_m.y) || !is_size(half_m.z)) return body;
  body.kind = Kind::box;
  body.half_m = half_m;
  return body;
}

Convex make_track(double radius_0_m, double radius_1_m, double length_m, double half_width_m) {
  Convex body;
  if (!is_size(radius_0_m) || !is_size(radius_1_m) || !is_size(half_width_m)) return body;
  if (!(length_m >= 0.0) || !std::isfinite(length_m)) return body;
  body.kind = Kind::track;
  body.half_m = {0.0, half_width_m, 0.0};
  body.radius_m[0] = radius_0_m;
  body.radius_m[1] = radius_1_m;
  body.length_m = length_m;
  const double step = radius_0_m - radius_1_m;
  if (length_m > std::fabs(step)) {
    const double sine = step / length_m;  // n . (c1 - c0) = r0 - r1 for the common tangent's normal n
    body.run_normal[0] = sine;
    body.run_normal[1] = std::sqrt((1.0 - sine) * (1.0 + sine));
    body.middle_m.x = 0.5 * length_m;
    return body;
  }
  // One wheel contains the other: a cylinder about the larger one's axis.
  body.middle_m.x = step < 0.0 ? length_m : 0.0;
  body.radius_m[0] = body.radius_m[1] = step < 0.0 ? radius_1_m : radius_0_m;
  body.first_x_m = body.middle_m.x;
  body.length_m = 0.0;
  body.run_normal[1] = 1.0;
  return body;
}

Convex make_cylinder(double radius_m, double half_length_m) {
  return make_track(radius_m, radius_m, 0.0, half_length_m);
}

Convex make_swept_ellipsoid(const Vector3& radii_m, const Vector3& half_sweep_m) {
  Convex body;
  if (!is_size(radii_m.x) || !is_size(radii_m.y) || !is_size(radii_m.z) || !is_finite(half_sweep_m))
    return body;
  body.kind = Kind::swept_ellipsoid;
  body.half_m = radii_m;
  body.sweep_m = half_sweep_m;
  return body;
}

void place(Convex& body, const Vector3& p_world_m, const Quaternion& q_world_body) {
  body.p_world_m = p_world_m;
  body.R_world_body = to_matrix(q_world_body);
}

bool is_valid(const Convex& body) {
  double sum = 0.0;  // one NaN or infinity anywhere stays visible in the sum of products with zero
  for (const double x : body.R_world_body.m) sum += 0.0 * x;
  sum += 0.0 * (body.p_world_m.x + body.half_m.x + body.sweep_m.x + body.radius_m[0]);
  sum += 0.0 * (body.p_world_m.y + body.half_m.y + body.sweep_m.y + body.radius_m[1]);
  sum += 0.0 * (body.p_world_m.z + body.half_m.z + body.sweep_m.z + body.length_m);
  return body.kind != Kind::none && sum == 0.0;
}

}  // namespace sortie::rt::convex
