// SPDX-License-Identifier: BSD-3-Clause
// The point nearest to the origin of a point, segment, triangle or tetrahedron, and the corners that span it.
#pragma once

#include <cstdint>

#include "rt/rotation.hpp"

namespace sortie::rt::convex {

/// A corner: a difference of two bodies' points, with both points kept.
struct SimplexCorner {
  Vector3 difference{};
  Vector3 on_a{};
  Vector3 on_b{};
};

/// One to four corners, with the weights of the nearest point after reduce().
struct Simplex {
  SimplexCorner corners[4]{};
  double weights[4]{};
  std::uint32_t count{};
};

/// Drops the corners that the nearest point does not need and sets the weights; they are >= 0 and add up
/// to 1. False when the origin lies inside a tetrahedron. Flat and collapsed simplices are judged by their
/// parts (Ericson 2005, 5.1: by regions). Corners before `first_new` were reduced before: parts of them alone
/// are not looked at again. 5-40 ns.
bool reduce(Simplex& simplex, std::uint32_t first_new = 0);

/// The nearest point, from the weights.
Vector3 nearest_difference(const Simplex& simplex);

}  // namespace sortie::rt::convex
