// SPDX-License-Identifier: BSD-3-Clause
// Points on the planes of a hall, and the cells that they make: what planes are grown from.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "mapping/registration/plane_growing.hpp"
#include "tests/mapping/plane_scenes.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace sortie::tests {

/// `count` points on planes, by area, with noise along the normal.
inline std::vector<Eigen::Vector3d> points_on(const std::vector<mapping::Plane>& planes, std::size_t count,
                                              double noise_m, WorldRandom& random) {
  double area = 0.0;
  for (const mapping::Plane& p : planes) area += p.area_m2;
  std::vector<Eigen::Vector3d> points;
  for (const mapping::Plane& p : planes) {
    const auto own = static_cast<std::size_t>(p.area_m2 / area * static_cast<double>(count) + 0.5);
    const rt::Vector3 v = p.axis_v();
    for (std::size_t i = 0; i < own; ++i) {
      const double a = random.between(p.least_m[0], p.most_m[0]);
      const double b = random.between(p.least_m[1], p.most_m[1]);
      const double d = noise_m * random.normal();
      const rt::Vector3 x = p.centroid_m + a * p.axis_u + b * v + d * p.normal;
      points.emplace_back(x.x, x.y, x.z);
    }
  }
  return points;
}

/// The cells of points, sorted by place.
inline std::vector<mapping::PlaneCell> cells_of(const std::vector<Eigen::Vector3d>& points, double edge_m) {
  struct Sums {
    double n = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d product = Eigen::Matrix3d::Zero();
  };
  std::map<std::array<std::int32_t, 3>, Sums> sums;
  for (const Eigen::Vector3d& p : points) {
    std::array<std::int32_t, 3> at{};
    Eigen::Vector3d local;
    for (int i = 0; i < 3; ++i) {
      at[static_cast<std::size_t>(i)] = static_cast<std::int32_t>(std::floor(p[i] / edge_m));
      local[i] = p[i] - (at[static_cast<std::size_t>(i)] + 0.5) * edge_m;
    }
    Sums& s = sums[at];
    s.n += 1;
    s.sum += local;
    s.product += local * local.transpose();
  }
  std::vector<mapping::PlaneCell> cells;
  for (const auto& [at, s] : sums) {
    const Eigen::Vector3d mean = s.sum / s.n;
    const testing::Eigen3 eigen = testing::eigen_of(s.product / s.n - mean * mean.transpose());
    mapping::PlaneCell cell;
    for (int i = 0; i < 3; ++i) {
      cell.at[i] = at[static_cast<std::size_t>(i)];
      cell.mean_m[i] = static_cast<float>(mean[i]);
      cell.normal[i] = static_cast<float>(eigen.vectors(i, 0));
      cell.variance_m2[i] = static_cast<float>(std::max(0.0, eigen.values[i]));
    }
    cell.count = static_cast<std::uint32_t>(s.n);
    cells.push_back(cell);
  }
  return cells;
}

/// A growing with memory of its own.
struct OwnedGrowing {
  explicit OwnedGrowing(const mapping::PlaneGrowingConfig& config, std::size_t capacity = 16384,
                        std::size_t region_capacity = 1024)
      : cells(capacity),
        table(4 * capacity),
        heap(capacity),
        queue(capacity),
        regions(region_capacity),
        growing(config, {cells, table, heap, queue, regions}) {}
  bool run_all() {
    std::uint64_t units = std::uint64_t{1} << 60;
    return growing.run(units);
  }

  std::vector<mapping::PlaneCellSlot> cells;
  std::vector<std::uint32_t> table;
  std::vector<std::uint64_t> heap;
  std::vector<std::uint32_t> queue;
  std::vector<mapping::PlaneRegion> regions;
  mapping::PlaneGrowing growing;
};

}  // namespace sortie::tests
