// SPDX-License-Identifier: BSD-3-Clause
// The shapes that a simulated world is made of, and what a ray, a point and an outline meet of one of them.
#pragma once

#include <cstdint>
#include <limits>

#include "hil/geometry.hpp"

namespace sortie::hil {

/// Kinds of solid. Three stand upright, boxes and wedges turned about the vertical; the others lie anyhow.
enum class SolidKind : std::uint8_t {
  box,              ///< |x| <= half_x, |y| <= half_y, bottom <= z <= top (local frame)
  wedge,            ///< like a box, but its roof rises from `low` at x = -half_x to `top` at x = +half_x
  cylinder,         ///< x^2 + y^2 <= half_x^2, bottom <= z <= top
  tilted_box,       ///< |x| <= half.x, |y| <= half.y, |z| <= half.z along its axes
  tilted_cylinder,  ///< x^2 + z^2 <= half.x^2, |y| <= half.y along its axes
};

/// Unit axes of a solid in the world.
struct Axes {
  Vec3 x{1, 0, 0};
  Vec3 y{0, 1, 0};
  Vec3 z{0, 0, 1};
};

/// The axes of a frame. `q_world_frame` has length 1.
constexpr Axes axes_of(const Quat& q_world_frame) {
  return {rotate(q_world_frame, {1, 0, 0}), rotate(q_world_frame, {0, 1, 0}),
          rotate(q_world_frame, {0, 0, 1})};
}

/// One solid of the world, closed (its surface belongs to it). Metres, world frame; use the make_ functions.
struct Solid {
  SolidKind kind{};
  bool drivable{};               ///< a robot may stand on its roof and is not stopped by it
  std::uint16_t reflectivity{};  ///< what a lidar reports at normal incidence
  double center_x_m{};
  double center_y_m{};
  double cos_yaw{1};
  double sin_yaw{};
  double half_x_m{};  ///< the radius of a cylinder
  double half_y_m{};
  double bottom_m{};
  double top_m{};
  double low_m{};  ///< wedge: height of the roof at its foot
  // Of tilted solids alone; the members above are then those of their upright bounding box.
  Vec3 half_m{};
  Axes axes{};
};

/// True for the kinds that may lie in any attitude.
constexpr bool is_tilted(const Solid& solid) {
  return solid.kind == SolidKind::tilted_box || solid.kind == SolidKind::tilted_cylinder;
}

/// Plain description of a box or wedge, as a builder writes it.
struct BoxShape {
  double center_x_m{};
  double center_y_m{};
  double yaw_rad{};
  double length_m{};  ///< along the local x
  double width_m{};   ///< along the local y
  double bottom_m{};
  double top_m{};
};

/// A box. Cost: one sincos.
Solid make_box(const BoxShape& shape, std::uint16_t reflectivity = 100, bool drivable = false);
/// A ramp whose roof rises along the local x from `shape.bottom_m` to `shape.top_m`. Drivable.
Solid make_wedge(const BoxShape& shape, std::uint16_t reflectivity = 100);
/// An upright cylinder.
Solid make_cylinder(double center_x_m, double center_y_m, double radius_m, double bottom_m, double top_m,
                    std::uint16_t reflectivity = 100);

/// A box in any attitude, `half_m` along its axes. Nobody drives on its roof.
Solid make_tilted_box(const Vec3& center_m, const Axes& axes, const Vec3& half_m);
/// A cylinder about the y axis of its frame, in any attitude.
Solid make_tilted_cylinder(const Vec3& center_m, const Axes& axes, double radius_m, double half_length_m);

/// A ray; `direction` must have length 1, so that the parameter is the range in metres.
struct Ray {
  Vec3 origin_m;
  Vec3 direction;
};

/// First point of a ray in a solid.
struct Contact {
  double range_m{std::numeric_limits<double>::infinity()};  ///< infinity: no contact; 0: the origin is inside
  Vec3 normal;  ///< outward, world frame; zero when the origin is inside
};

/// First point of `ray` in `solid`, at any range >= 0. Exact up to rounding. No heap. Cost: 5 to 15 ns.
Contact intersect(const Ray& ray, const Solid& solid);

/// Height of the roof above (x, y), or -infinity where the solid is not below or above that point.
double roof_height(const Solid& solid, double x_m, double y_m);

/// Half the extents of the upright bounding box, for the broad phase.
void half_extents(const Solid& solid, double& half_x_m, double& half_y_m);

/// An upright prism on a turned rectangle: the outline of a robot.
struct Footprint {
  double center_x_m{};
  double center_y_m{};
  double cos_yaw{1};
  double sin_yaw{};
  double half_x_m{};
  double half_y_m{};
  double bottom_m{};
  double top_m{};
};

/// True if the prism and the solid share inner points. Separating axes for boxes, nearest point for
/// cylinders; wedges and tilted solids count as their upright bounding boxes.
bool overlaps(const Footprint& prism, const Solid& solid);

}  // namespace sortie::hil
