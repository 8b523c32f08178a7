// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grid/self_filter.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {

bool is_size(double value) { return std::isfinite(value) && value >= 0.0; }

bool is_usable(const SelfFilterConfig& config) {
  if (config.box_count > SelfFilterConfig::kMaxBoxes || !is_size(config.margin_m) ||
      !is_size(config.shadow_m))
    return false;
  for (std::uint32_t i = 0; i < config.box_count; ++i) {
    const BodyBox& box = config.boxes[i];
    if (!rt::is_finite(box.centre_m) || !is_size(box.half_m.x) || !is_size(box.half_m.y) ||
        !is_size(box.half_m.z))
      return false;
  }
  const FlipperOutline& f = config.flippers;
  if (!is_size(f.length_m)) return false;
  if (f.length_m == 0.0) return true;
  return rt::is_finite(f.pivot_m) && is_size(f.large_radius_m) && is_size(f.small_radius_m) &&
         is_size(f.half_width_m) && f.large_radius_m < f.length_m + f.small_radius_m &&
         f.small_radius_m <= f.large_radius_m;
}

}  // namespace

SelfFilter::SelfFilter(const SelfFilterConfig& config) : config_(config) {
  if (!is_usable(config)) {
    usable_ = Status::out_of_range;
    config_ = {};
    config_.margin_m = 0.0;
    config_.shadow_m = 0.0;
    return;
  }
  double reach = -1.0;
  for (std::uint32_t i = 0; i < config.box_count; ++i)
    reach = std::max(reach, rt::norm(config.boxes[i].centre_m) + rt::norm(config.boxes[i].half_m));
  const FlipperOutline& f = config.flippers;
  if (f.length_m > 0.0) {
    reach = std::max(reach, rt::norm(f.pivot_m) + f.length_m + f.large_radius_m + f.half_width_m);
    taper_sin_ = (f.large_radius_m - f.small_radius_m) / f.length_m;
    taper_cos_ = std::sqrt(1.0 - taper_sin_ * taper_sin_);
  }
  if (reach >= 0.0) reach2_m2_ = (reach + config.margin_m) * (reach + config.margin_m);
  reach_m_ = std::max(reach, 0.0) + config.shadow_m;
  const double level[rt::kFlippers]{};
  static_cast<void>(set_flippers(level));
}

Status SelfFilter::set_flippers(const double (&angle_rad)[rt::kFlippers]) {
  for (const double angle : angle_rad) {
    if (!std::isfinite(angle)) return Status::not_finite;
  }
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    const rt::SinCos turn = rt::sincos(angle_rad[i]);
    along_x_[i] = i < 2 ? turn.cos : -turn.cos;
    along_z_[i] = turn.sin;
  }
  return Status::ok;
}

bool SelfFilter::is_robot(const rt::Vector3& p) const {
  return rt::dot(p, p) < reach2_m2_ && is_within(p, config_.margin_m);
}

bool SelfFilter::is_shadowed(const rt::Vector3& sensor, const rt::Vector3& p) const {
  if (config_.shadow_m <= 0.0) return false;
  const rt::Vector3 way = p - sensor;
  const double range_m = rt::norm(way);
  // The sensor sits on the robot: the first of the way says nothing, and none of it beyond all outlines.
  constexpr double kOfSensor_m = 0.15;
  const double end_m = std::min(range_m, rt::norm(sensor) + reach_m_);
  const double step_m = std::max(config_.shadow_m, 0.05 * reach_m_);
  for (double along_m = kOfSensor_m; along_m < end_m; along_m += step_m) {
    const rt::Vector3 at = sensor + (along_m / range_m) * way;
    if (rt::dot(at, at) < reach_m_ * reach_m_ && is_within(at, config_.shadow_m)) return true;
  }
  return false;
}

bool SelfFilter::is_within(const rt::Vector3& p, double margin_m) const {
  for (std::uint32_t i = 0; i < config_.box_count; ++i) {
    const BodyBox& box = config_.boxes[i];
    if (std::fabs(p.x - box.centre_m.x) <= box.half_m.x + margin_m &&
        std::fabs(p.y - box.centre_m.y) <= box.half_m.y + margin_m &&
        std::fabs(p.z - box.centre_m.z) <= box.half_m.z + margin_m)
      return true;
  }
  if (config_.flippers.length_m == 0.0) return false;
  for (std::uint32_t i = 0; i < rt::kFlippers; ++i) {
    if (on_flipper(i, p, margin_m)) return true;
  }
  return false;
}

// In the flipper's plane, from the large wheel's axle: `along` towards the small wheel, `side` square to it.
// Nearest is the large wheel, the small wheel or the tangent between them, as the point lies before, behind
// or between the two radii that end on that tangent.
bool SelfFilter::on_flipper(std::uint32_t flipper, const rt::Vector3& p, double margin_m) const {
  const FlipperOutline& f = config_.flippers;
  const double mirror_x = flipper < 2 ? 1.0 : -1.0;
  const double mirror_y = flipper % 2 == 0 ? 1.0 : -1.0;
  if (std::fabs(p.y - mirror_y * f.pivot_m.y) > f.half_width_m + margin_m) return false;
  const double x = p.x - mirror_x * f.pivot_m.x;
  const double z = p.z - f.pivot_m.z;
  const double along = along_x_[flipper] * x + along_z_[flipper] * z;
  const double side = std::fabs(along_x_[flipper] * z - along_z_[flipper] * x);
  const double on_tangent = taper_cos_ * along - taper_sin_ * side;
  double distance = 0.0;
  if (on_tangent <= 0.0) {
    distance = std::sqrt(along * along + side * side) - f.large_radius_m;
  } else if (on_tangent >= taper_cos_ * f.length_m) {
    distance = std::sqrt((along - f.length_m) * (along - f.length_m) + side * side) - f.small_radius_m;
  } else {
    distance = taper_sin_ * along + taper_cos_ * side - f.large_radius_m;
  }
  return distance <= margin_m;
}

}  // namespace sortie::mapping
