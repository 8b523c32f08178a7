// SPDX-License-Identifier: BSD-3-Clause
// From a direction of some overlap to one of the smallest overlap around it.
#pragma once

#include <cstdint>

#include "rt/convex/axes.hpp"

namespace sortie::rt::convex {

/// A direction, and the point midway between the bodies' surfaces there.
struct Descent {
  Axis axis{};
  Vector3 point_m{};
  bool found{};
};

/// Moves a away along the direction until a gap of `clearance_m` is left and takes the direction between the
/// nearest points there. Its overlap is never larger: with q the shift, h the reach of b - a, and m the gap,
/// the nearest points are m' >= m apart, and h(d') = q.d' - m' <= |q| - m = h(d). Repeated up to three times
/// while it helps. `calls_left` pays for calls of support() and ends the search.
Descent descend(const Convex& a, const Convex& b, const Vector3& start, double clearance_m,
                std::uint32_t& calls_left);

/// The direction between the nearest points of two bodies that are apart; not found where they are not.
Descent nearest_direction(const Convex& a, const Convex& b, const Vector3& start, std::uint32_t& calls_left);

}  // namespace sortie::rt::convex
