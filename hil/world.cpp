// SPDX-License-Identifier: BSD-3-Clause
// Scene storage and its queries. The rays walk the cells of world_grid.cpp.
#include "hil/world.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::hil {
namespace {

bool finite(const Solid& s) {
  return std::isfinite(s.center_x_m) && std::isfinite(s.center_y_m) && std::isfinite(s.cos_yaw) &&
         std::isfinite(s.sin_yaw) && std::isfinite(s.half_x_m) && std::isfinite(s.half_y_m) &&
         std::isfinite(s.bottom_m) && std::isfinite(s.top_m) && std::isfinite(s.low_m) &&
         std::isfinite(dot(s.half_m, s.half_m)) && std::isfinite(dot(s.axes.x, s.axes.x)) &&
         std::isfinite(dot(s.axes.y, s.axes.y)) && std::isfinite(dot(s.axes.z, s.axes.z));
}

void meet_ground(const Ray& ray, Hit& best) {
  if (ray.origin_m.z <= 0.0) {
    best = {0.0, {}, Hit::kGround, World::kGroundReflectivity};
  } else if (ray.direction.z < 0.0) {
    const double range = -ray.origin_m.z / ray.direction.z;
    if (range < best.range_m) best = {range, {0, 0, 1}, Hit::kGround, World::kGroundReflectivity};
  }
}

}  // namespace

Status World::add(const Solid& solid) {
  if (!finite(solid)) return Status::not_finite;
  if (!(solid.half_x_m > 0.0 && solid.half_y_m > 0.0 && solid.top_m > solid.bottom_m)) {
    return Status::out_of_range;
  }
  if (is_tilted(solid) && !(solid.half_m.x > 0.0 && solid.half_m.y > 0.0 && solid.half_m.z > 0.0))
    return Status::out_of_range;
  if (count_ == kMaxSolids) return Status::full;
  solids_[count_] = solid;
  ++count_;
  ready_ = false;
  return Status::ok;
}

Hit World::cast(const Vec3& origin_m, const Vec3& direction, double max_range_m) const {
  if (!ready_) return cast_brute_force(origin_m, direction, max_range_m);
  const Ray ray{origin_m, direction};
  Hit best{max_range_m, {}, Hit::kNothing, 0};
  meet_ground(ray, best);
  if (count_ > 0) cast_cells(ray, best);
  return best;
}

Hit World::cast_brute_force(const Vec3& origin_m, const Vec3& direction, double max_range_m) const {
  const Ray ray{origin_m, direction};
  Hit best{max_range_m, {}, Hit::kNothing, 0};
  meet_ground(ray, best);
  for (std::size_t i = 0; i < count_; ++i) try_solid(i, ray, best);
  return best;
}

double World::terrain_height(double x_m, double y_m) const {
  double height = 0.0;
  if (!ready_ || count_ == 0) return height;
  const std::int32_t cell = row(y_m) * kCells + column(x_m);
  for (std::uint16_t k = cell_begin_[static_cast<std::size_t>(cell)];
       k < cell_begin_[static_cast<std::size_t>(cell) + 1]; ++k) {
    const Solid& candidate = solids_[entries_[k]];
    if (candidate.drivable) height = std::max(height, roof_height(candidate, x_m, y_m));
  }
  return height;
}

bool World::blocked(const Footprint& outline) const {
  if (!ready_ || count_ == 0) return false;
  const double reach_x =
      std::fabs(outline.cos_yaw) * outline.half_x_m + std::fabs(outline.sin_yaw) * outline.half_y_m;
  const double reach_y =
      std::fabs(outline.sin_yaw) * outline.half_x_m + std::fabs(outline.cos_yaw) * outline.half_y_m;
  for (std::int32_t r = row(outline.center_y_m - reach_y); r <= row(outline.center_y_m + reach_y); ++r) {
    for (std::int32_t c = column(outline.center_x_m - reach_x); c <= column(outline.center_x_m + reach_x);
         ++c) {
      const auto cell = static_cast<std::size_t>(r) * kCells + static_cast<std::size_t>(c);
      for (std::uint16_t k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) {
        const Solid& candidate = solids_[entries_[k]];
        if (!candidate.drivable && overlaps(outline, candidate)) return true;
      }
    }
  }
  return false;
}

}  // namespace sortie::hil
