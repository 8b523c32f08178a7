// SPDX-License-Identifier: BSD-3-Clause
// Closed-form intersections of a ray and of a footprint with one solid.
#include "hil/solid.hpp"

#include <algorithm>
#include <cmath>

#include "hil/ray_clip.hpp"

namespace sortie::hil {
namespace {

Local to_local(const Solid& solid, double x, double y) {
  return {solid.cos_yaw * x + solid.sin_yaw * y, solid.cos_yaw * y - solid.sin_yaw * x};
}

Vec3 to_world(const Solid& solid, const Vec3& v) {
  return {solid.cos_yaw * v.x - solid.sin_yaw * v.y, solid.sin_yaw * v.x + solid.cos_yaw * v.y, v.z};
}

double roof_slope(const Solid& solid) { return (solid.top_m - solid.low_m) / (2.0 * solid.half_x_m); }

}  // namespace

Solid make_box(const BoxShape& shape, std::uint16_t reflectivity, bool drivable) {
  Solid solid;
  solid.kind = SolidKind::box;
  solid.drivable = drivable;
  solid.reflectivity = reflectivity;
  solid.center_x_m = shape.center_x_m;
  solid.center_y_m = shape.center_y_m;
  solid.cos_yaw = rt::cos(shape.yaw_rad);
  solid.sin_yaw = rt::sin(shape.yaw_rad);
  solid.half_x_m = 0.5 * shape.length_m;
  solid.half_y_m = 0.5 * shape.width_m;
  solid.bottom_m = shape.bottom_m;
  solid.top_m = shape.top_m;
  solid.low_m = shape.top_m;
  return solid;
}

Solid make_wedge(const BoxShape& shape, std::uint16_t reflectivity) {
  Solid solid = make_box(shape, reflectivity, true);
  solid.kind = SolidKind::wedge;
  solid.low_m = shape.bottom_m;
  return solid;
}

Solid make_cylinder(double center_x_m, double center_y_m, double radius_m, double bottom_m, double top_m,
                    std::uint16_t reflectivity) {
  Solid solid =
      make_box({center_x_m, center_y_m, 0.0, 2.0 * radius_m, 2.0 * radius_m, bottom_m, top_m}, reflectivity);
  solid.kind = SolidKind::cylinder;
  return solid;
}

Contact intersect(const Ray& ray, const Solid& solid) {
  if (is_tilted(solid)) return intersect_tilted(ray, solid);
  const Local o = to_local(solid, ray.origin_m.x - solid.center_x_m, ray.origin_m.y - solid.center_y_m);
  const Local d = to_local(solid, ray.direction.x, ray.direction.y);
  Clip clip;
  if (solid.kind == SolidKind::cylinder) {
    clip_round(clip, o, d, solid.half_x_m);
  } else {
    clip.slab(o.x, d.x, solid.half_x_m, {1, 0, 0});
    clip.slab(o.y, d.y, solid.half_y_m, {0, 1, 0});
  }
  if (clip.missed()) return {};
  clip.half_space(solid.bottom_m - ray.origin_m.z, -ray.direction.z, {0, 0, -1});
  if (solid.kind == SolidKind::wedge) {
    const double slope = roof_slope(solid);
    const double scale = 1.0 / std::sqrt(1.0 + slope * slope);
    clip.half_space(ray.origin_m.z - solid.low_m - slope * (o.x + solid.half_x_m),
                    ray.direction.z - slope * d.x, {-slope * scale, 0, scale});
  } else {
    clip.half_space(ray.origin_m.z - solid.top_m, ray.direction.z, {0, 0, 1});
  }
  if (clip.missed()) return {};
  if (clip.near_m <= 0.0) return {0.0, {}};
  return {clip.near_m, to_world(solid, clip.normal)};
}

double roof_height(const Solid& solid, double x_m, double y_m) {
  if (is_tilted(solid)) {  // what falls from above it meets
    const double above = solid.top_m + 1.0;
    return above - intersect({{x_m, y_m, above}, {0, 0, -1}}, solid).range_m;
  }
  const Local p = to_local(solid, x_m - solid.center_x_m, y_m - solid.center_y_m);
  const bool inside = solid.kind == SolidKind::cylinder
                          ? p.x * p.x + p.y * p.y <= solid.half_x_m * solid.half_x_m
                          : std::fabs(p.x) <= solid.half_x_m && std::fabs(p.y) <= solid.half_y_m;
  if (!inside) return -std::numeric_limits<double>::infinity();
  if (solid.kind != SolidKind::wedge) return solid.top_m;
  return solid.low_m + roof_slope(solid) * (p.x + solid.half_x_m);
}

void half_extents(const Solid& solid, double& half_x_m, double& half_y_m) {
  const double c = std::fabs(solid.cos_yaw);
  const double s = std::fabs(solid.sin_yaw);
  const bool round = solid.kind == SolidKind::cylinder;
  half_x_m = round ? solid.half_x_m : c * solid.half_x_m + s * solid.half_y_m;
  half_y_m = round ? solid.half_x_m : s * solid.half_x_m + c * solid.half_y_m;
}

bool overlaps(const Footprint& prism, const Solid& solid) {
  if (prism.top_m <= solid.bottom_m || prism.bottom_m >= solid.top_m) return false;
  const double dx = solid.center_x_m - prism.center_x_m;
  const double dy = solid.center_y_m - prism.center_y_m;
  // The solid's centre in the frame of the prism.
  const double px = std::fabs(prism.cos_yaw * dx + prism.sin_yaw * dy);
  const double py = std::fabs(prism.cos_yaw * dy - prism.sin_yaw * dx);
  if (solid.kind == SolidKind::cylinder) {
    const double gap_x = std::max(px - prism.half_x_m, 0.0);
    const double gap_y = std::max(py - prism.half_y_m, 0.0);
    return gap_x * gap_x + gap_y * gap_y < solid.half_x_m * solid.half_x_m;
  }
  const double c = std::fabs(prism.cos_yaw * solid.cos_yaw + prism.sin_yaw * solid.sin_yaw);
  const double s = std::fabs(prism.cos_yaw * solid.sin_yaw - prism.sin_yaw * solid.cos_yaw);
  const double ox = std::fabs(solid.cos_yaw * dx + solid.sin_yaw * dy);
  const double oy = std::fabs(solid.cos_yaw * dy - solid.sin_yaw * dx);
  return px < prism.half_x_m + c * solid.half_x_m + s * solid.half_y_m &&
         py < prism.half_y_m + s * solid.half_x_m + c * solid.half_y_m &&
         ox < solid.half_x_m + c * prism.half_x_m + s * prism.half_y_m &&
         oy < solid.half_y_m + s * prism.half_x_m + c * prism.half_y_m;
}

}  // namespace sortie::hil
