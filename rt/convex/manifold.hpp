// SPDX-License-Identifier: BSD-3-Clause
// The points in which two bodies press on each other: up to 8, in a fixed order, with names that stay while
// the configuration stays. Deterministic: a pure function of the input, the same bits on every processor.
#pragma once

#include <cstdint>

#include "rt/convex/query.hpp"
#include "rt/convex/shape.hpp"

namespace sortie::rt::convex {

/// One point of contact.
struct Contact {
  Vector3 point_m{};   ///< midway between the two surfaces, in the world
  Vector3 normal{};    ///< unit vector out of b INTO a: the force on a is along +normal
  double depth_m{};    ///< overlap along the normal here; negative is a gap, at most the margin
  std::uint32_t id{};  ///< which features meet; for warm starting. Never twice in one manifold
};

/// All points of contact of one pair.
struct Manifold {
  Contact contacts[8]{};
  std::uint32_t count{};
  State state{State::separated};  ///< `unknown` carries the contacts that were found, at least one
};

/// What a caller may choose.
struct ManifoldOptions {
  double margin_m{0.001};          ///< gaps up to this become contacts with a negative depth; >= 0
  std::uint32_t max_contacts{8};   ///< 4 to 8; the deepest and those that span the largest area are kept
  double face_preference_m{1e-4};  ///< faces win over edges that are less deep by no more than this
  Budget budget{};
};

/// The contacts of a (a track, a flipper, a robot's body) with b (an obstacle). Normals point into a. No
/// contact when the gap is wider than the margin.
Manifold manifold(const Convex& a, const Convex& b, const ManifoldOptions& options = {});

/// The contacts of a with the ground, in closed form. Normals are the ground's.
Manifold manifold(const Convex& a, const HalfSpace& ground, const ManifoldOptions& options = {});

}  // namespace sortie::rt::convex
