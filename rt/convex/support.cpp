// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/support.hpp"

#include <algorithm>
#include <cmath>

#include "rt/convex/local.hpp"

namespace sortie::rt::convex {
namespace {

double towards(double direction, double size) { return direction >= 0.0 ? size : -size; }

// 1 / |(x, z)|, or 0 where that is no number: a zero direction then asks for the middle of the wheel.
double inverse_length(double x, double z) {
  const double n2 = x * x + z * z;
  return n2 > 0.0 && std::isfinite(n2) ? 1.0 / std::sqrt(n2) : 0.0;
}

Vector3 track_support(const Convex& t, const Vector3& d) {
  const double inverse = inverse_length(d.x, d.z);
  const double x = inverse == 0.0 ? 0.0 : d.x * inverse;
  const double z = inverse == 0.0 ? 0.0 : d.z * inverse;
  const bool far = t.length_m * x + t.radius_m[1] > t.radius_m[0];
  const double r = t.radius_m[far ? 1 : 0];
  return {t.first_x_m + (far ? t.length_m : 0.0) + r * x, towards(d.y, t.half_m.y), r * z};
}

Vector3 ellipsoid_support(const Convex& e, const Vector3& d) {
  const Vector3 stretched{e.half_m.x * d.x, e.half_m.y * d.y, e.half_m.z * d.z};
  const Vector3 end = dot(e.sweep_m, d) >= 0.0 ? e.sweep_m : -1.0 * e.sweep_m;
  const double n2 = dot(stretched, stretched);
  if (!(n2 > 0.0) || !std::isfinite(n2)) return end;
  const double s = 1.0 / std::sqrt(n2);
  return end + Vector3{e.half_m.x * (s * stretched.x), e.half_m.y * (s * stretched.y),
                       e.half_m.z * (s * stretched.z)};
}

double local_reach(const Convex& body, const Vector3& d) {
  switch (body.kind) {
    case Kind::box:
      return body.half_m.x * std::fabs(d.x) + body.half_m.y * std::fabs(d.y) + body.half_m.z * std::fabs(d.z);
    case Kind::track: {
      const double length = std::sqrt(d.x * d.x + d.z * d.z);
      const double near_wheel = body.radius_m[0] * length;
      const double far_wheel = body.length_m * d.x + body.radius_m[1] * length;
      return body.first_x_m * d.x + (far_wheel > near_wheel ? far_wheel : near_wheel) +
             body.half_m.y * std::fabs(d.y);
    }
    case Kind::swept_ellipsoid:
      return std::fabs(dot(body.sweep_m, d)) +
             norm({body.half_m.x * d.x, body.half_m.y * d.y, body.half_m.z * d.z});
    case Kind::none:
      break;
  }
  return 0.0;
}

// Signed distance, negative inside, from a point (x, z) to the outline of a track; z >= 0 by symmetry. The
// nearest part is wheel 0, the run or wheel 1, by where the point falls along the run.
double outline_distance(const Convex& t, double x, double z) {
  const double nx = t.run_normal[0];
  const double nz = t.run_normal[1];
  const double along = x * nz - z * nx;
  if (along <= 0.0) return std::sqrt(x * x + z * z) - t.radius_m[0];
  if (along >= t.length_m * nz) {
    const double from_far = x - t.length_m;
    return std::sqrt(from_far * from_far + z * z) - t.radius_m[1];
  }
  return x * nx + z * nz - t.radius_m[0];
}

bool ellipsoid_contains(const Convex& e, const Vector3& p) {
  const Vector3 q{p.x / e.half_m.x, p.y / e.half_m.y, p.z / e.half_m.z};
  const Vector3 s{e.sweep_m.x / e.half_m.x, e.sweep_m.y / e.half_m.y, e.sweep_m.z / e.half_m.z};
  const double s2 = dot(s, s);
  double t = s2 > 0.0 ? dot(q, s) / s2 : 0.0;
  t = t > 1.0 ? 1.0 : (t < -1.0 ? -1.0 : t);
  const Vector3 rest = q - t * s;
  return dot(rest, rest) <= 1.0;
}

}  // namespace

Vector3 support(const Convex& body, const Vector3& dir_world) {
  const Vector3 d = to_body(body, dir_world);
  switch (body.kind) {
    case Kind::box:
      return to_world(
          body, {towards(d.x, body.half_m.x), towards(d.y, body.half_m.y), towards(d.z, body.half_m.z)});
    case Kind::track:
      return to_world(body, track_support(body, d));
    case Kind::swept_ellipsoid:
      return to_world(body, ellipsoid_support(body, d));
    case Kind::none:
      break;
  }
  return body.p_world_m;
}

double reach(const Convex& body, const Vector3& dir_world, const Vector3& reference_world_m) {
  return dot(dir_world, body.p_world_m - reference_world_m) + local_reach(body, to_body(body, dir_world));
}

Reach reach_both(const Convex& body, const Vector3& dir_world, const Vector3& reference_world_m) {
  const Vector3 d = to_body(body, dir_world);
  const double along = dot(dir_world, body.p_world_m - reference_world_m);
  if (body.kind != Kind::track) {  // the others are their own mirror images
    const double reach = local_reach(body, d);
    return {along + reach, reach - along};
  }
  const double length = std::sqrt(d.x * d.x + d.z * d.z);
  const double near_wheel = body.radius_m[0] * length;
  const double far_wheel = body.radius_m[1] * length;
  const double ahead = body.length_m * d.x + far_wheel;
  const double behind = far_wheel - body.length_m * d.x;
  const double first = body.first_x_m * d.x;
  const double side = body.half_m.y * std::fabs(d.y);
  return {along + (first + (ahead > near_wheel ? ahead : near_wheel) + side),
          (((behind > near_wheel ? behind : near_wheel) - first) + side) - along};
}

Vector3 middle(const Convex& body) { return to_world(body, body.middle_m); }

double thickness(const Convex& body) {
  if (body.kind == Kind::track) return std::min({body.radius_m[0], body.radius_m[1], body.half_m.y});
  return std::min({body.half_m.x, body.half_m.y, body.half_m.z});
}

Vector3 inside_near(const Convex& body, const Vector3& towards_world_m) {
  const Vector3 p = to_body(body, towards_world_m - body.p_world_m);
  const auto within = [](double x, double limit) { return std::clamp(x, -limit, limit); };
  switch (body.kind) {
    case Kind::box:
      return to_world(body, {within(p.x, 0.9 * body.half_m.x), within(p.y, 0.9 * body.half_m.y),
                             within(p.z, 0.9 * body.half_m.z)});
    case Kind::track:
      return to_world(body, {body.first_x_m + std::clamp(p.x - body.first_x_m, 0.0, body.length_m),
                             within(p.y, 0.9 * body.half_m.y), 0.0});
    case Kind::swept_ellipsoid: {
      const double s2 = dot(body.sweep_m, body.sweep_m);
      const double t = s2 > 0.0 ? within(dot(p, body.sweep_m) / s2, 1.0) : 0.0;
      return to_world(body, t * body.sweep_m);
    }
    case Kind::none:
      break;
  }
  return middle(body);
}

Bounds bounds(const Convex& body) {
  double low[3];
  double high[3];
  for (int i = 0; i < 3; ++i) {
    const double* row = &body.R_world_body.m[3 * i];
    high[i] = local_reach(body, {row[0], row[1], row[2]});
    low[i] = -local_reach(body, {-row[0], -row[1], -row[2]});
  }
  return {body.p_world_m + to_vector(low), body.p_world_m + to_vector(high)};
}

bool contains(const Convex& body, const Vector3& point_world_m) {
  const Vector3 p = to_body(body, point_world_m - body.p_world_m);
  switch (body.kind) {
    case Kind::box:
      return std::fabs(p.x) <= body.half_m.x && std::fabs(p.y) <= body.half_m.y &&
             std::fabs(p.z) <= body.half_m.z;
    case Kind::track:
      return std::fabs(p.y) <= body.half_m.y &&
             outline_distance(body, p.x - body.first_x_m, std::fabs(p.z)) <= 0.0;
    case Kind::swept_ellipsoid:
      return ellipsoid_contains(body, p);
    case Kind::none:
      break;
  }
  return false;
}

}  // namespace sortie::rt::convex
