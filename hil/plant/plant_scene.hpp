// SPDX-License-Identifier: BSD-3-Clause
// What the tracked vehicle stands on and runs into: boxes, cylinders and half-spaces in fixed memory.
#pragma once

#include "hil/geometry.hpp"
#include "rt/convex/shape.hpp"
#include "rt/convex/support.hpp"
#include "rt/fixed_vector.hpp"
#include "rt/status.hpp"

namespace sortie::hil {

/// Static obstacles, world frame, z up. About 80 kB: keep it off small stacks. No heap. Const after the last
/// add: several plants may share it.
class PlantScene {
 public:
  static constexpr std::uint32_t kMaxSolids = 256;
  static constexpr std::uint32_t kMaxHalfSpaces = 8;

  /// An obstacle and its upright bounding box.
  struct Solid {
    rt::convex::Convex shape;
    rt::convex::Bounds bounds;
  };

  /// Everything below a plane: `normal` points out of the ground and need not have length 1; `point_m` lies
  /// on it. Status: ok, full, not_finite, out_of_range (no direction).
  Status add_half_space(const Vec3& normal, const Vec3& point_m);

  /// A box. Status: ok, full, not_finite, out_of_range (a half edge that is not above 0).
  Status add_box(const Vec3& centre_m, const Quat& q_world_box, const Vec3& half_m);

  /// A cylinder whose axis is the y axis of its frame. Status as for a box.
  Status add_cylinder(const Vec3& centre_m, const Quat& q_world_cylinder, double radius_m,
                      double half_length_m);

  const rt::FixedVector<Solid, kMaxSolids>& solids() const { return solids_; }
  const rt::FixedVector<rt::convex::HalfSpace, kMaxHalfSpaces>& half_spaces() const { return half_spaces_; }

 private:
  Status add(rt::convex::Convex shape, const Vec3& centre_m, const Quat& q_world_shape);

  rt::FixedVector<Solid, kMaxSolids> solids_;
  rt::FixedVector<rt::convex::HalfSpace, kMaxHalfSpaces> half_spaces_;
};

}  // namespace sortie::hil
