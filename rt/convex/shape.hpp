// SPDX-License-Identifier: BSD-3-Clause
// Convex bodies in the world: boxes, tracks and flippers (the hull of two wheels on parallel axes),
// cylinders, and an ellipsoid swept along a line. Plain values: copying is safe, nothing is owned, no heap.
#pragma once

#include <cstdint>

#include "rt/rotation.hpp"

namespace sortie::rt::convex {

/// What a body is. `none` is what a factory returns for sizes that make no body.
enum class Kind : std::uint8_t { none, box, track, swept_ellipsoid };

/// A convex body and where it is. Made by the factories below; `p_world_m` and `R_world_body` may be written
/// at any time, the sizes may not. About 260 bytes.
struct Convex {
  Kind kind{Kind::none};
  Vector3 p_world_m{};            ///< origin of the body frame in the world
  RotationMatrix R_world_body{};  ///< columns are the body's axes in the world
  Vector3 half_m{};               ///< box: half edges. Track: {unused, half width, unused}. Ellipsoid: radii
  double radius_m[2]{};           ///< track: radius of the wheel at the origin, and of the wheel at +x
  double first_x_m{};             ///< track: x of wheel 0's axis: 0, unless the other wheel is all there is
  double length_m{};              ///< track: distance of the wheels' axes
  double run_normal[2]{};  ///< track: {x, z} of the upper run's outward normal; the lower one's is {x, -z}
  Vector3 sweep_m{};       ///< ellipsoid: half of the sweep; its two ends are at -sweep and +sweep
  Vector3 middle_m{};      ///< a point deep inside, in the body frame
};

/// A box; its frame is in its middle. Half edges must be positive and finite, else kind is `none`.
Convex make_box(const Vector3& half_m);

/// A track or a flipper: the hull of two cylinders whose axes are parallel to y. The frame lies on the axis
/// of wheel 0 in the middle of its width; wheel 1 is at x = `length_m`. Where one wheel contains the other,
/// the body is that wheel alone, a cylinder. Radii and half width must be positive and finite, the length
/// finite and not negative, else kind is `none`.
Convex make_track(double radius_0_m, double radius_1_m, double length_m, double half_width_m);

/// A cylinder about its frame's y axis, with flat ends at y = +-`half_length_m`: a track of length 0.
Convex make_cylinder(double radius_m, double half_length_m);

/// The hull of two equal ellipsoids (radii along the frame's axes) whose centres are at -`half_sweep_m` and
/// +`half_sweep_m` in the frame: what a flying robot covers on a straight line. Radii must be positive and
/// finite, the sweep finite, else kind is `none`.
Convex make_swept_ellipsoid(const Vector3& radii_m, const Vector3& half_sweep_m);

/// Moves a body. `q_world_body` is a unit quaternion.
void place(Convex& body, const Vector3& p_world_m, const Quaternion& q_world_body);

/// True when the kind is not `none` and pose and sizes are finite. Queries check this themselves.
bool is_valid(const Convex& body);

/// Everything below the plane {x : normal . x = offset}: the ground. The normal is a unit vector.
struct HalfSpace {
  Vector3 normal{0, 0, 1};
  double offset_m{};
};

}  // namespace sortie::rt::convex
