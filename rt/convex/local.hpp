// SPDX-License-Identifier: BSD-3-Clause
// Small steps that several files here share: body frames and unit vectors.
#pragma once

#include <cmath>

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// A world direction in the body frame.
constexpr Vector3 to_body(const Convex& body, const Vector3& v) {
  const double* m = body.R_world_body.m;
  return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
          m[2] * v.x + m[5] * v.y + m[8] * v.z};
}

/// A point of the body frame in the world.
constexpr Vector3 to_world(const Convex& body, const Vector3& p) {
  return body.p_world_m + body.R_world_body * p;
}

/// One of the body's axes (0-2) in the world.
constexpr Vector3 axis_of(const Convex& body, int i) {
  const double* m = body.R_world_body.m;
  return {m[i], m[i + 3], m[i + 6]};
}

/// `v` brought to length 1, into `unit`. False, and nothing written, where v has no direction: shorter than
/// 1e-12 (the cross product of directions that are as good as parallel), or not finite.
inline bool normalise(const Vector3& v, Vector3& unit) {
  const double n2 = dot(v, v);
  if (!(n2 > 1e-24) || !std::isfinite(n2)) return false;
  unit = (1.0 / std::sqrt(n2)) * v;
  return true;
}

}  // namespace sortie::rt::convex
