// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/street_town.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/bench/recognition/hall_things.hpp"

namespace sortie::bench {
namespace {
using testing::Draws;

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kMargin_m = 0.5;   ///< between things
constexpr double kWay_m = 1.5;      ///< clear on either side of the way
constexpr double kBeside_m = 16.0;  ///< from the way, to a thing's nearest side
constexpr double kTries = 2.0;      ///< a metre of way
constexpr double kBefore_m = 100.0;
constexpr double kSameRoad_m = 5.0;

Thing draw_tree(Draws& draws) {
  Thing thing;
  const double crown = draws.uniform(0.7, 1.8), bottom = draws.uniform(1.8, 2.8);
  thing.cylinder(draws.uniform(0.12, 0.3), bottom);
  thing.cylinder(crown, draws.uniform(1.5, 3.5));
  thing.parts.back().foot.z = bottom;
  return thing;
}

Thing draw_car(Draws& draws) {
  Thing thing;
  const double half = draws.uniform(1.9, 2.4), wide = draws.uniform(0.8, 0.95);
  thing.box(0, 0, half, wide, draws.uniform(0.7, 1.0), 0.2);
  thing.box(draws.uniform(-0.5, 0.2), 0, 0.55 * half, 0.9 * wide, draws.uniform(1.3, 1.9));
  return thing;
}

Thing draw_house(Draws& draws) {
  Thing thing;
  const double x = draws.uniform(2.5, 6.0), y = draws.uniform(2.5, 5.0);
  thing.box(0, 0, x, y, draws.uniform(3.0, 8.0));
  if (draws.uniform(0, 1) < 0.5)  // a porch, a garage
    thing.box(draws.uniform(-0.5, 0.5) * x, y, draws.uniform(0.8, 1.8), draws.uniform(0.8, 2.0),
              draws.uniform(2.2, 3.0));
  return thing;
}

Thing draw_town_thing(Draws& draws) {
  const double kind = draws.uniform(0, 1);
  if (kind < 0.35) return draw_thing(draws, 3.0);
  if (kind < 0.60) return draw_tree(draws);
  if (kind < 0.70) {
    Thing pole;
    pole.cylinder(draws.uniform(0.08, 0.2), draws.uniform(3.0, 6.0));
    return pole;
  }
  if (kind < 0.82) return draw_car(draws);
  if (kind < 0.90) {
    Thing wall;
    wall.box(0, 0, draws.uniform(1.5, 5.0), 0.1, draws.uniform(0.8, 2.2));
    return wall;
  }
  return draw_house(draws);
}

}  // namespace

StreetTown::StreetTown(const StreetCourse& course, Draws& draws) {
  struct Taken {
    double x, y, radius;
  };
  std::vector<Taken> taken;
  const auto is_free = [&](double x, double y, double radius) {
    for (const Taken& other : taken) {
      if (std::hypot(x - other.x, y - other.y) < radius + other.radius + kMargin_m) return false;
    }
    for (const CoursePose& pose : course.poses) {
      if (std::hypot(x - pose.x, y - pose.y) < radius + kWay_m) return false;
    }
    return true;
  };
  // Streets that are driven twice have no more things than others.
  const std::vector<double> left_m = distance_to_left(course, kBefore_m);
  double due = 0.0;
  for (std::size_t i = 0; i < course.poses.size(); ++i) {
    if (left_m[i] < kSameRoad_m) continue;
    for (due += kTries * course.step_m; due >= 1.0; due -= 1.0) {
      const CoursePose& pose = course.poses[i];
      const Thing thing = draw_town_thing(draws);
      const double side = draws.uniform(0, 1) < 0.5 ? -1.0 : 1.0;
      const double off = side * (kWay_m + thing.radius + draws.uniform(0.0, kBeside_m));
      // Half of them along the road, as houses and cars are.
      const double yaw = pose.heading + (draws.uniform(0, 1) < 0.5 ? 0.0 : draws.uniform(0, 2 * M_PI));
      const double x = pose.x - off * std::sin(pose.heading), y = pose.y + off * std::cos(pose.heading);
      if (!is_free(x, y, thing.radius)) continue;
      put(solids_, thing, {x, y, 0}, yaw);
      taken.push_back({x, y, thing.radius});
    }
  }
  things_ = taken.size();
  sort_into_cells();
}

void StreetTown::sort_into_cells() {
  if (solids_.empty()) return;
  const auto reach = [](const HallSolid& one) { return one.round ? one.half_x : one.half_x + one.half_y; };
  double far_x = -kNever, far_y = -kNever;
  corner_x_ = corner_y_ = kNever;
  for (const HallSolid& one : solids_) {
    corner_x_ = std::min(corner_x_, one.foot.x - reach(one));
    corner_y_ = std::min(corner_y_, one.foot.y - reach(one));
    far_x = std::max(far_x, one.foot.x + reach(one));
    far_y = std::max(far_y, one.foot.y + reach(one));
  }
  columns_ = static_cast<int>((far_x - corner_x_) / kCell_m) + 1;
  rows_ = static_cast<int>((far_y - corner_y_) / kCell_m) + 1;
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  const auto number = [](double along) { return static_cast<int>(along / kCell_m); };
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const HallSolid& one = solids_[i];
    const double x = one.foot.x - corner_x_, y = one.foot.y - corner_y_, r = reach(one);
    for (int row = number(y - r); row <= number(y + r); ++row) {
      for (int column = number(x - r); column <= number(x + r); ++column)
        cells_[static_cast<std::size_t>(row * columns_ + column)].push_back(static_cast<std::uint32_t>(i));
    }
  }
}

double StreetTown::range(const rt::Vector3& from, const rt::Vector3& ray) const {
  double least = ray.z < 0.0 ? from.z / -ray.z : kNever;  // the ground
  // Cell after cell along the ray (J. Amanatides, A. Woo, A Fast Voxel Traversal Algorithm, 1987).
  const double x = (from.x - corner_x_) / kCell_m, y = (from.y - corner_y_) / kCell_m;
  int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const auto to_edge = [](double at, int cell, double along) {
    if (along == 0.0) return kNever;
    return ((along > 0.0 ? cell + 1 : cell) - at) * kCell_m / along;
  };
  double next_x = to_edge(x, column, ray.x), next_y = to_edge(y, row, ray.y);
  const double step_x = ray.x == 0.0 ? kNever : kCell_m / std::fabs(ray.x);
  const double step_y = ray.y == 0.0 ? kNever : kCell_m / std::fabs(ray.y);
  for (double entered = 0.0; entered < std::min(least, kReach_m);) {
    if (is_inside(column, row)) {
      for (const std::uint32_t i : cell(column, row))
        least = std::min(least, range_to(solids_[i], from, ray));
    }
    entered = std::min(next_x, next_y);
    if (next_x < next_y) {
      column += ray.x > 0.0 ? 1 : -1;
      next_x += step_x;
    } else {
      row += ray.y > 0.0 ? 1 : -1;
      next_y += step_y;
    }
  }
  return least <= kReach_m ? least : kNever;
}

}  // namespace sortie::bench
