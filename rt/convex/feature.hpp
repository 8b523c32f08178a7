// SPDX-License-Identifier: BSD-3-Clause
// The part of a body's surface that faces a direction, as a polygon: what contact manifolds are cut from.
#pragma once

#include <cstdint>

#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// A polygon (3-8 vertices), an edge (2) or a point (1) on a body's surface, in the world. `ids` names each
/// vertex, and `id` the whole, in the same way in every call: contacts are followed over time by them.
struct Feature {
  Vector3 vertices_m[8]{};
  std::uint8_t ids[8]{};
  std::uint8_t count{};
  std::uint8_t id{};
  bool flat{};       ///< a face whose outward normal is `normal`
  Vector3 normal{};  ///< only of a flat one
};

/// The face of the body that looks within about 15 degrees of `dir_world` (a unit vector), else the edge that
/// does (for the round parts of a track: the line of the cylinder in that direction), else the outermost
/// point. Vertices go round counter-clockwise as seen from outside. 20-60 ns, no heap.
Feature feature(const Convex& body, const Vector3& dir_world);

}  // namespace sortie::rt::convex
