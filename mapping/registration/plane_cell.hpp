// SPDX-License-Identifier: BSD-3-Clause
// What the growing of planes needs to know of a cell of a grid, and sums over many of them in whole numbers.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_algebra.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// Points of one cell as a Gaussian. The cell covers [at, at + 1) edges of the grid.
struct PlaneCell {
  std::int32_t at[3]{};    ///< whole coordinates, each in [-2^19, 2^19)
  float mean_m[3]{};       ///< of the points, from the cell's centre; within one edge
  float normal[3]{};       ///< unit, along the least variance
  float variance_m2[3]{};  ///< along the axes, rising
  std::uint32_t count{};   ///< points; 0: the cell is empty
  SORTIE_FIELDS(at, mean_m, normal, variance_m2, count)
};

/// Steps of an edge that means are rounded to (0.4 mm for 0.4 m).
inline constexpr std::int32_t kPlaneSteps = 1024;
/// Furthest that a cell may lie from the one that sums are relative to, in cells.
inline constexpr std::int32_t kPlaneReach = 1024;
/// Heaviest a cell can be.
inline constexpr std::uint32_t kPlaneWeight = 64;

/// Weighted sums over points in whole steps, relative to the centre of an anchor cell: exact, so that what
/// was added can be taken away again and no order matters. Below 2^61 for 16,384 cells within kPlaneReach.
struct PlaneSums {
  static constexpr int kAxes[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};  ///< of products
  std::int64_t weight{};
  std::int64_t sum[3]{};
  std::int64_t product[6]{};  ///< xx, yy, zz, xy, xz, yz
  SORTIE_FIELDS(weight, sum, product)

  /// `sign`: 1, or -1 to take away again.
  void add(const PlaneSums& other, std::int64_t sign = 1) {
    weight += sign * other.weight;
    for (int i = 0; i < 3; ++i) sum[i] += sign * other.sum[i];
    for (int k = 0; k < 6; ++k) product[k] += sign * other.product[k];
  }
  /// The same relative to an anchor `d` steps back: every point moves by d.
  void shift(const std::int64_t (&d)[3]) {
    for (int k = 0; k < 6; ++k) {
      const auto [i, j] = kAxes[k];
      product[k] += d[i] * sum[j] + d[j] * sum[i] + d[i] * d[j] * weight;
    }
    for (int i = 0; i < 3; ++i) sum[i] += d[i] * weight;
  }
};

/// A cell's own sums, relative to its own centre. Its variances across the normal count as equal.
inline PlaneSums sums_of(const PlaneCell& cell, double edge_m, std::uint32_t most_weight) {
  const double step_m = edge_m / kPlaneSteps;
  const auto whole = [](double v) { return static_cast<std::int64_t>(v < 0.0 ? v - 0.5 : v + 0.5); };
  PlaneSums out;
  out.weight = cell.count < most_weight ? cell.count : most_weight;
  std::int64_t mean[3];
  for (int i = 0; i < 3; ++i) {
    mean[i] = whole(static_cast<double>(cell.mean_m[i]) / step_m);
    out.sum[i] = out.weight * mean[i];
  }
  const double across =
      0.5 * (static_cast<double>(cell.variance_m2[1]) + static_cast<double>(cell.variance_m2[2]));
  const double along = static_cast<double>(cell.variance_m2[0]) - across;
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = PlaneSums::kAxes[k];
    const double part = along * static_cast<double>(cell.normal[i]) * static_cast<double>(cell.normal[j]);
    out.product[k] =
        out.weight * (mean[i] * mean[j] + whole((part + (i == j ? across : 0.0)) / (step_m * step_m)));
  }
  return out;
}

/// The plane that sums make: its axes and variances, in m, relative to the anchor's centre.
struct PlaneMoments {
  rt::Vector3 mean_m;
  rt::Vector3 normal;       ///< the first of z, y, x that is not 0 is positive
  rt::Vector3 axis_u;       ///< of most variance
  double variance_m2[3]{};  ///< rising: along normal, normal x u, u
};

/// Exact until divided: sums are brought to the step below their mean first, so that the same points give the
/// same bits at any distance. ~0.5 us. weight > 0.
inline PlaneMoments moments_of(PlaneSums sums, double edge_m) {
  const double step_m = edge_m / kPlaneSteps;
  std::int64_t middle[3];
  for (int i = 0; i < 3; ++i)  // rounded down, wherever the anchor is
    middle[i] = -(sums.sum[i] / sums.weight - (sums.sum[i] % sums.weight < 0 ? 1 : 0));
  sums.shift(middle);
  const double n = static_cast<double>(sums.weight);
  double mean[3];
  for (int i = 0; i < 3; ++i) mean[i] = static_cast<double>(sums.sum[i]) / n;
  constexpr int kAt[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
  double c[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c[i][j] = (static_cast<double>(sums.product[kAt[i][j]]) / n - mean[i] * mean[j]) * (step_m * step_m);
  }
  const EigenPairs<3> eigen = eigen_pairs(c);
  PlaneMoments out;
  out.mean_m = {step_m * (mean[0] - static_cast<double>(middle[0])),
                step_m * (mean[1] - static_cast<double>(middle[1])),
                step_m * (mean[2] - static_cast<double>(middle[2]))};
  rt::Vector3 normal{eigen.vector[0][0], eigen.vector[1][0], eigen.vector[2][0]};
  const double sign = normal.z != 0.0 ? normal.z : normal.y != 0.0 ? normal.y : normal.x;
  out.normal = (sign < 0.0 ? -1.0 : 1.0) / rt::norm(normal) * normal;
  out.axis_u = {eigen.vector[0][2], eigen.vector[1][2], eigen.vector[2][2]};
  for (int k = 0; k < 3; ++k) out.variance_m2[k] = eigen.value[k] > 0.0 ? eigen.value[k] : 0.0;
  return out;
}

}  // namespace sortie::mapping
