// SPDX-License-Identifier: BSD-3-Clause
// libccd's Minkowski portal refinement behind a budget: the only place that calls libccd.
//
// Two of its loops have no bound of their own. Here the support functions count; past the budget they give
// the same point again, which ends those loops (no portal grows by a point that it has), and the answer is
// `exhausted`, whatever libccd says.
#pragma once

#include <cstdint>

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// Any convex body, given by its outermost point in a direction (which may be zero or a NaN).
struct SupportBody {
  using Function = Vector3 (*)(const void* body, const Vector3& direction);
  const void* body{};
  Function support{};
  Vector3 inside{};  ///< a point inside; the nearer to the other body, the better the direction found
};

/// What the refinement says.
enum class PortalState : std::uint8_t { apart, meeting, exhausted };

/// The answer. Directions point from b into a, as in convex/axes.hpp. They are proposals: their overlap must
/// be measured, and a gap is proved only by a negative one.
struct PortalResult {
  PortalState state{PortalState::exhausted};
  Vector3 last_direction{};   ///< the last one that was tried: where `apart`, it mostly proves the gap
  Vector3 depth_direction{};  ///< where `meeting`: the direction of the depth along the ray of the middles
  std::uint32_t support_calls{};
};

/// Runs the refinement. At most `budget` calls of support functions. 200-500 ns for boxes. No heap.
PortalResult refine_portal(const SupportBody& a, const SupportBody& b, std::uint32_t budget);

}  // namespace sortie::rt::convex
