// SPDX-License-Identifier: BSD-3-Clause
// Bodies as points of their surfaces, turned and put into cells as a map would have them.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "mapping/recognition/segment_shape.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

/// Places in steps of 1/256 of a cell.
using StepPoints = std::vector<std::array<std::int32_t, 3>>;

inline mapping::SegmentMoments moments_of(const StepPoints& points) {
  mapping::SegmentMoments moments;
  for (const auto& p : points) moments.add({p[0], p[1], p[2]});
  return moments;
}

/// Both visits.
inline mapping::SegmentDescriptor describe(const StepPoints& points, double voxel_size_m = 0.1) {
  const mapping::SegmentFrame frame = mapping::frame_of(moments_of(points), voxel_size_m);
  mapping::SegmentShape shape;
  for (const auto& p : points) shape.add(frame, {p[0], p[1], p[2]});
  return mapping::descriptor_of(frame, shape);
}

/// Points of surfaces, m.
struct Body {
  const char* name;
  std::vector<rt::Vector3> points;

  /// A flat piece: a corner and two edges, a point each 2 cm.
  void plate(const rt::Vector3& corner, const rt::Vector3& a, const rt::Vector3& b) {
    const int na = static_cast<int>(rt::norm(a) / 0.02) + 1, nb = static_cast<int>(rt::norm(b) / 0.02) + 1;
    for (int i = 0; i <= na; ++i) {
      for (int k = 0; k <= nb; ++k) points.push_back(corner + (1.0 * i / na) * a + (1.0 * k / nb) * b);
    }
  }
  /// Four sides and a top.
  void box(const rt::Vector3& corner, double x, double y, double z) {
    plate(corner, {x, 0, 0}, {0, 0, z});
    plate(corner, {0, y, 0}, {0, 0, z});
    plate(corner + rt::Vector3{0, y, 0}, {x, 0, 0}, {0, 0, z});
    plate(corner + rt::Vector3{x, 0, 0}, {0, y, 0}, {0, 0, z});
    plate(corner + rt::Vector3{0, 0, z}, {x, 0, 0}, {0, y, 0});
  }
  /// An upright round one, its radius at the foot and at the top.
  void cone(const rt::Vector3& foot, double low, double high, double z) {
    for (int i = 0; i <= static_cast<int>(z / 0.02); ++i) {
      const double up = 0.02 * i, r = low + (high - low) * up / z;
      const int around = static_cast<int>(2 * M_PI * r / 0.02) + 1;
      for (int k = 0; k < around; ++k) {
        const double turn = 2 * M_PI * k / around;
        points.push_back(foot + rt::Vector3{r * std::cos(turn), r * std::sin(turn), up});
      }
    }
  }
};

/// Things of a building and around it, no two alike.
inline std::vector<Body> bodies() {
  std::vector<Body> all;
  const auto add = [&all](const char* name) -> Body& { return all.emplace_back(Body{name, {}}); };
  add("wall").plate({0, 0, 0}, {6, 0, 0}, {0, 0, 2.5});
  Body& corner = add("corner of walls");
  corner.plate({0, 0, 0}, {4, 0, 0}, {0, 0, 2.5});
  corner.plate({0, 0, 0}, {0, 3, 0}, {0, 0, 2.5});
  add("cupboard").box({0, 0, 0}, 1.2, 0.6, 2.0);
  add("crate").box({0, 0, 0}, 1.5, 1.5, 1.2);
  add("pole").cone({0, 0, 0}, 0.12, 0.12, 3.0);
  add("cone").cone({0, 0, 0}, 1.0, 0.05, 2.0);
  add("funnel").cone({0, 0, 0}, 0.05, 1.0, 2.0);
  Body& table = add("table");
  table.plate({0, 0, 0.9}, {2.4, 0, 0}, {0, 1.2, 0});
  for (const double x : {0.1, 2.3}) {
    for (const double y : {0.1, 1.1}) table.cone({x, y, 0}, 0.03, 0.03, 0.9);
  }
  add("ramp").plate({0, 0, 0}, {4, 0, 2}, {0, 1.2, 0});
  Body& car = add("car");
  car.box({0, 0, 0.3}, 4.2, 1.8, 0.6);
  car.box({1.6, 0.1, 0.9}, 2.2, 1.6, 0.6);
  Body& tree = add("tree");
  tree.cone({0, 0, 0}, 0.15, 0.12, 2.2);
  tree.cone({0, 0, 2.2}, 0.2, 1.3, 1.0);
  tree.cone({0, 0, 3.2}, 1.3, 0.2, 1.2);
  return all;
}

/// The means of a body's points in cells of `voxel_size_m`, after a turn about the upright and a move. By the
/// order of cells.
inline StepPoints mapped(const Body& body, double yaw_rad, const rt::Vector3& move_m,
                         double voxel_size_m = 0.1) {
  struct Sum {
    double at[3]{};
    int count{};
  };
  std::map<std::array<std::int32_t, 3>, Sum> cells;
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  for (const rt::Vector3& p : body.points) {
    const double at[3] = {(c * p.x - s * p.y + move_m.x) / voxel_size_m,
                          (s * p.x + c * p.y + move_m.y) / voxel_size_m, (p.z + move_m.z) / voxel_size_m};
    std::array<std::int32_t, 3> cell;
    for (unsigned i = 0; i < 3; ++i) cell[i] = static_cast<std::int32_t>(std::floor(at[i]));
    Sum& sum = cells[cell];
    for (int i = 0; i < 3; ++i) sum.at[i] += at[i];
    ++sum.count;
  }
  StepPoints points;
  for (const auto& [cell, sum] : cells) {
    std::array<std::int32_t, 3>& point = points.emplace_back();
    for (unsigned i = 0; i < 3; ++i)
      point[i] = static_cast<std::int32_t>(std::floor(256.0 * sum.at[i] / sum.count));
  }
  return points;
}

}  // namespace sortie::testing
