// SPDX-License-Identifier: BSD-3-Clause
// Normal and curvature of a set of points from the sums over it: the smallest eigenvalue of a 3x3 matrix
// without trigonometry, heap or a loop without end.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mapping/normal_record.hpp"

namespace sortie::mapping {

/// A symmetric 3x3 matrix.
struct Symmetric3 {
  double xx{};
  double yy{};
  double zz{};
  double xy{};
  double xz{};
  double yz{};
};

/// Direction of least spread, unit length, and its share of the spread: l0 / (l0 + l1 + l2), in [0, 1/3].
struct PlaneFit {
  double normal[3]{};
  double curvature{};
};

/// n^2 times the covariance of what a record sums up. Exact: whole numbers below 2^53.
inline Symmetric3 scaled_covariance(const NormalRecord& r) {
  const auto n = static_cast<std::int64_t>(r.count);
  const auto square = [&r, n](int i) {
    return static_cast<double>(n * r.square[i] - std::int64_t{r.sum[i]} * r.sum[i]);
  };
  const auto product = [&r, n](int at, int i, int k) {
    return static_cast<double>(n * r.product[at] - std::int64_t{r.sum[i]} * r.sum[k]);
  };
  return {square(0), square(1), square(2), product(0, 0, 1), product(1, 0, 2), product(2, 1, 2)};
}

/// Smallest eigenvalue of a positive semidefinite matrix of trace 1. Laguerre's method from 0: all roots are
/// real, so it climbs towards the smallest one and never past it. Two or three steps where the root is alone,
/// one where it is a triple one.
inline double smallest_eigenvalue(const Symmetric3& m) {
  const double minors = m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + m.yy * m.zz - m.yz * m.yz;
  const double determinant = m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) +
                             m.xz * (m.xy * m.yz - m.yy * m.xz);
  // p(l) = -l^3 + l^2 - minors l + determinant, falling until the smallest root.
  double l = 0.0;
  for (int i = 0; i < 16; ++i) {
    const double value = ((1.0 - l) * l - minors) * l + determinant;
    const double slope = (2.0 - 3.0 * l) * l - minors;
    if (!(value > 0.0 && slope < 0.0)) break;
    const double inner = 4.0 * slope * slope - 6.0 * value * (2.0 - 6.0 * l);
    const double step = 3.0 * value / (std::sqrt(std::max(inner, 0.0)) - slope);
    l += step;
    if (step < 1e-9) break;
  }
  return std::clamp(l, 0.0, 1.0 / 3.0);
}

/// Fits a plane. False when the matrix is empty (all points in one place): nothing is said then. Of all
/// points on a line some normal square to it comes out. The sign is such that the first of z, y, x that is
/// not 0 is positive.
inline bool fit_plane(const Symmetric3& covariance, PlaneFit& fit) {
  const double trace = covariance.xx + covariance.yy + covariance.zz;
  if (!(trace > 0.0)) return false;
  const double s = 1.0 / trace;
  Symmetric3 m{s * covariance.xx, s * covariance.yy, s * covariance.zz,
               s * covariance.xy, s * covariance.xz, s * covariance.yz};
  fit.curvature = smallest_eigenvalue(m);
  m.xx -= fit.curvature;
  m.yy -= fit.curvature;
  m.zz -= fit.curvature;
  // Rows of the rest span the plane: the longest of their cross products is the safest.
  const double cross[3][3] = {
      {m.xy * m.yz - m.xz * m.yy, m.xz * m.xy - m.xx * m.yz, m.xx * m.yy - m.xy * m.xy},
      {m.xy * m.zz - m.xz * m.yz, m.xz * m.xz - m.xx * m.zz, m.xx * m.yz - m.xy * m.xz},
      {m.yy * m.zz - m.yz * m.yz, m.yz * m.xz - m.xy * m.zz, m.xy * m.yz - m.yy * m.xz}};
  int best = 0;
  double longest = -1.0;
  for (int i = 0; i < 3; ++i) {
    const double length2 = cross[i][0] * cross[i][0] + cross[i][1] * cross[i][1] + cross[i][2] * cross[i][2];
    if (length2 <= longest) continue;
    longest = length2;
    best = i;
  }
  double n[3] = {cross[best][0], cross[best][1], cross[best][2]};
  if (longest < 1e-24) {  // A line, or no direction at all: square to the longest row.
    const double rows[3][3] = {{m.xx, m.xy, m.xz}, {m.xy, m.yy, m.yz}, {m.xz, m.yz, m.zz}};
    int row = 0;
    if (m.yy > rows[row][row]) row = 1;
    if (m.zz > rows[row][row]) row = 2;
    const double* const a = rows[row];
    if (std::fabs(a[0]) <= std::fabs(a[1]) && std::fabs(a[0]) <= std::fabs(a[2])) {
      n[0] = 0, n[1] = -a[2], n[2] = a[1];
    } else if (std::fabs(a[1]) <= std::fabs(a[2])) {
      n[0] = -a[2], n[1] = 0, n[2] = a[0];
    } else {
      n[0] = -a[1], n[1] = a[0], n[2] = 0;
    }
    longest = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(longest > 0.0)) {
      n[2] = 1.0;
      longest = 1.0;
    }
  }
  const bool flip = n[2] < 0.0 || (n[2] == 0.0 && (n[1] < 0.0 || (n[1] == 0.0 && n[0] < 0.0)));
  const double scale = (flip ? -1.0 : 1.0) / std::sqrt(longest);
  for (int i = 0; i < 3; ++i) fit.normal[i] = scale * n[i];
  return true;
}

}  // namespace sortie::mapping
