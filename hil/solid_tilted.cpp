// SPDX-License-Identifier: BSD-3-Clause
// Boxes and cylinders in any attitude: what rubble, pallets and logs are made of.
#include <cmath>

#include "hil/ray_clip.hpp"
#include "hil/solid.hpp"

namespace sortie::hil {
namespace {

// A world vector along the axes of a tilted solid.
Vec3 to_axes(const Solid& solid, const Vec3& v) {
  return {dot(solid.axes.x, v), dot(solid.axes.y, v), dot(solid.axes.z, v)};
}

// `reach`: half the upright bounding box.
Solid make_tilted(SolidKind kind, const Vec3& center_m, const Axes& axes, const Vec3& half_m,
                  const Vec3& reach) {
  Solid solid;
  solid.kind = kind;
  solid.reflectivity = 100;
  solid.center_x_m = center_m.x;
  solid.center_y_m = center_m.y;
  solid.half_x_m = reach.x;
  solid.half_y_m = reach.y;
  solid.bottom_m = center_m.z - reach.z;
  solid.top_m = solid.low_m = center_m.z + reach.z;
  solid.half_m = half_m;
  solid.axes = axes;
  return solid;
}

}  // namespace

Solid make_tilted_box(const Vec3& center_m, const Axes& axes, const Vec3& half_m) {
  const auto reach = [&](double x, double y, double z) {
    return std::fabs(x) * half_m.x + std::fabs(y) * half_m.y + std::fabs(z) * half_m.z;
  };
  return make_tilted(SolidKind::tilted_box, center_m, axes, half_m,
                     {reach(axes.x.x, axes.y.x, axes.z.x), reach(axes.x.y, axes.y.y, axes.z.y),
                      reach(axes.x.z, axes.y.z, axes.z.z)});
}

Solid make_tilted_cylinder(const Vec3& center_m, const Axes& axes, double radius_m, double half_length_m) {
  const auto reach = [&](double axis) {
    return half_length_m * std::fabs(axis) + radius_m * std::sqrt(std::max(0.0, 1.0 - axis * axis));
  };
  return make_tilted(SolidKind::tilted_cylinder, center_m, axes, {radius_m, half_length_m, radius_m},
                     {reach(axes.y.x), reach(axes.y.y), reach(axes.y.z)});
}

Contact intersect_tilted(const Ray& ray, const Solid& solid) {
  const Vec3 middle{solid.center_x_m, solid.center_y_m, 0.5 * (solid.bottom_m + solid.top_m)};
  const Vec3 o = to_axes(solid, ray.origin_m - middle);
  const Vec3 d = to_axes(solid, ray.direction);
  Clip clip;
  clip.slab(o.y, d.y, solid.half_m.y, {0, 1, 0});
  if (solid.kind == SolidKind::tilted_cylinder) {
    clip_wheel(clip, o, d, solid.half_m.x);
  } else {
    clip.slab(o.x, d.x, solid.half_m.x, {1, 0, 0});
    clip.slab(o.z, d.z, solid.half_m.z, {0, 0, 1});
  }
  if (clip.missed()) return {};
  if (clip.near_m <= 0.0) return {0.0, {}};
  return {clip.near_m,
          clip.normal.x * solid.axes.x + clip.normal.y * solid.axes.y + clip.normal.z * solid.axes.z};
}

}  // namespace sortie::hil
