// SPDX-License-Identifier: BSD-3-Clause
// Stairs, pallet, ramp and rubble as boxes.
#include "hil/plant/obstacles.hpp"

#include "hil/random.hpp"

namespace sortie::hil {
namespace {

/// Adds boxes given in the approach's frame: x along the way, z up.
class Builder {
 public:
  Builder(PlantScene& scene, const Approach& where)
      : scene_(&scene), origin_(where.p_world_m), turn_(from_yaw_pitch_roll(where.yaw_rad, 0.0, 0.0)) {}

  void box(const Vec3& centre_m, const Vec3& half_m, const Quat& q_local = {}) {
    if (status_ != Status::ok) return;
    status_ = scene_->add_box(origin_ + rotate(turn_, centre_m), turn_ * q_local, half_m);
  }
  /// From one corner to the other.
  void span(const Vec3& low_m, const Vec3& high_m) { box(0.5 * (low_m + high_m), 0.5 * (high_m - low_m)); }
  Status status() const { return status_; }

 private:
  PlantScene* scene_;
  Vec3 origin_;
  Quat turn_;
  Status status_{Status::ok};
};

}  // namespace

Status add_stairs(PlantScene& scene, const Approach& where, const StairShape& shape) {
  Builder build(scene, where);
  const double end = shape.run_m * (shape.steps - 1) + shape.landing_m;
  for (int i = 0; i < shape.steps; ++i) {
    build.span({shape.run_m * i, -0.5 * shape.width_m, shape.rise_m * i},
               {end, 0.5 * shape.width_m, shape.rise_m * (i + 1)});
  }
  return build.status();
}

Status add_pallet(PlantScene& scene, const Approach& where) {
  Builder build(scene, where);
  constexpr double kAcross = 0.6;
  // Boards along the 1.2 m, across the way: edges at these places along the way.
  const double boards[5][2] = {
      {0.0, 0.145}, {0.1863, 0.2863}, {0.3275, 0.4725}, {0.5137, 0.6137}, {0.655, 0.8}};
  for (const auto& board : boards) build.span({board[0], -kAcross, 0.111}, {board[1], kAcross, 0.133});
  const double across[3][2] = {{-0.6, -0.455}, {-0.0725, 0.0725}, {0.455, 0.6}};
  const double along[3][2] = {{0.0, 0.1}, {0.3275, 0.4725}, {0.7, 0.8}};
  for (const auto& y : across) {
    build.span({0.0, y[0], 0.089}, {0.8, y[1], 0.111});
    for (const auto& x : along) build.span({x[0], y[0], 0.022}, {x[1], y[1], 0.089});
  }
  for (const auto& x : along) build.span({x[0], -kAcross, 0.0}, {x[1], kAcross, 0.022});
  return build.status();
}

Status add_ramp(PlantScene& scene, const Approach& where, double slope_rad, double length_m, double deck_m,
                double width_m) {
  Builder build(scene, where);
  constexpr double kThick = 0.5;  // of the slab, below its surface
  const rt::SinCos slope = rt::sincos(slope_rad);
  const double rise = length_m * slope.sin;
  const double foot = length_m * slope.cos;
  // The slab starts below ground so that its foot has no edge: half a metre more along the slope.
  const double middle = 0.5 * (length_m - 0.5);
  build.box(
      {middle * slope.cos + 0.5 * kThick * slope.sin, 0.0, middle * slope.sin - 0.5 * kThick * slope.cos},
      {0.5 * (length_m + 0.5), 0.5 * width_m, 0.5 * kThick}, from_yaw_pitch_roll(0.0, -slope_rad, 0.0));
  if (deck_m > 0.0) build.span({foot, -0.5 * width_m, rise - kThick}, {foot + deck_m, 0.5 * width_m, rise});
  return build.status();
}

Status add_rubble(PlantScene& scene, const Approach& where, double length_m, double width_m, int count,
                  std::uint64_t seed) {
  Builder build(scene, where);
  Random random(seed, 0x727562);
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(0.0, length_m);
    const double y = random.uniform(-0.5 * width_m, 0.5 * width_m);
    const double yaw = random.uniform(-3.14, 3.14);
    const double pitch = random.uniform(-0.3, 0.3);
    const double roll = random.uniform(-0.3, 0.3);
    const double half_x = random.uniform(0.04, 0.15);
    const double half_y = random.uniform(0.04, 0.15);
    const double half_z = random.uniform(0.04, 0.10);
    const double sunk = random.uniform(0.3, 0.9);
    build.box({x, y, half_z * (1.0 - 2.0 * sunk)}, {half_x, half_y, half_z},
              from_yaw_pitch_roll(yaw, pitch, roll));
  }
  return build.status();
}

}  // namespace sortie::hil
