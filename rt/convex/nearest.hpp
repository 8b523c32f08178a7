// SPDX-License-Identifier: BSD-3-Clause
// The nearest points of two bodies that are apart, by Gilbert, Johnson and Keerthi's method (1988), with a
// budget. Used on pairs that were moved apart along a direction: then it improves that direction.
#pragma once

#include <cstdint>

#include "rt/convex/shape.hpp"

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

/// The nearest points, and the direction between them.
struct NearestResult {
  bool apart{};         ///< a gap was found; the rest is only valid then
  Vector3 direction{};  ///< unit, from b's point to a's
  Vector3 on_a_m{};     ///< with the shift
  Vector3 on_b_m{};
  std::uint32_t support_calls{};
};

/// Nearest points of b and of a moved by `shift_m`; `start` is the first direction tried (from b into a).
/// Stops when the distance is known to a millionth or the budget is used up. `simplex` is empty at first;
/// given again for the same bodies with another shift, it saves most work. 30-50 ns a round and support().
NearestResult nearest_points(const Convex& a, const Vector3& shift_m, const Convex& b, const Vector3& start,
                             std::uint32_t budget, Simplex& simplex);

}  // namespace sortie::rt::convex
