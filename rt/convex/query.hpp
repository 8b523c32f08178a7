// SPDX-License-Identifier: BSD-3-Clause
// Do two bodies meet, how deep, and along which direction? "Free" is only said with a proof: a direction
// along which a gap lies between the bodies. Bounded work, no heap; a pure function of the input.
//
// How: exact separating axes for boxes; for the others the axes of faces and edges, then libccd's portal
// refinement (Snethen 2008; never its EPA, which takes heap memory and misjudges shallow contacts), whose
// direction is improved until it is a smallest depth: moving the bodies apart along it and finding their
// nearest points gives a direction with less overlap, or the same one.
#pragma once

#include <cstdint>

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// How two bodies stand to each other.
enum class State : std::uint8_t {
  separated,    ///< a gap was proved
  touching,     ///< neither a gap nor an overlap above 1e-9 m
  penetrating,  ///< they share inner points
  unknown,      ///< the budget ran out, or an input is not a body: to be treated as a collision
};

/// What a planner asks: everything but `separated` is a collision.
constexpr bool is_collision(State state) { return state != State::separated; }

/// An upper limit of work.
struct Budget {
  std::uint32_t support_calls{64};  ///< calls of support(), of either body, for the decision; then: `unknown`
  std::uint32_t polish_calls{128};  ///< and for a better direction; past them the best one so far is kept
};

/// How two bodies stand to each other, with numbers.
struct QueryResult {
  State state{State::unknown};
  double depth_m{};   ///< how far the bodies overlap along `normal`; a gap is negative
  Vector3 normal{};   ///< unit vector out of b into a: moving a by depth * normal makes the bodies touch
  Vector3 point_m{};  ///< midway between the two surfaces where they are nearest or deepest
  std::uint32_t support_calls{};  ///< work that was done
};

/// Judges two bodies. `depth_m` is the overlap along `normal`, so always an upper bound of the penetration
/// depth and, negative, a proved lower bound of the gap. For `unknown` because of the budget, normal and
/// depth are the best that was found; for bodies that are none, the normal is +z and the depth 0.
QueryResult query(const Convex& a, const Convex& b, const Budget& budget = {});

}  // namespace sortie::rt::convex
