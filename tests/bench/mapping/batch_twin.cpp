// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/mapping/batch_twin.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/bench/mapping/rand_index.hpp"

namespace sortie::bench {
namespace {

std::int64_t cell_of(double v, double cell_m) { return static_cast<std::int64_t>(std::floor(v / cell_m)); }

/// Union-find without ranks, halving paths.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

/// Eigenvalues of a symmetric matrix, ascending, and the vector of the smallest: cyclic Jacobi.
void jacobi(double (&a)[3][3], double (&values)[3], TwinPoint& smallest) {
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = a[0][1] * a[0][1] + a[0][2] * a[0][2] + a[1][2] * a[1][2];
    if (off < 1e-34 * (a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2])) break;
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (a[p][q] == 0) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta < 0 ? -1.0 : 1.0) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1);
        const double s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p];
          a[k][p] = c * kp - s * a[k][q];
          a[k][q] = s * kp + c * a[k][q];
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k];
          a[p][k] = c * pk - s * a[q][k];
          a[q][k] = s * pk + c * a[q][k];
        }
        for (auto& row : v) {
          const double kp = row[p];
          row[p] = c * kp - s * row[q];
          row[q] = s * kp + c * row[q];
        }
      }
    }
  }
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&a](int i, int k) { return a[i][i] < a[k][k]; });
  for (int i = 0; i < 3; ++i) values[i] = a[order[i]][order[i]];
  smallest = {v[0][order[0]], v[1][order[0]], v[2][order[0]]};
}

double like(const TwinNormal& a, const TwinNormal& b) {
  return std::fabs(a.normal[0] * b.normal[0] + a.normal[1] * b.normal[1] + a.normal[2] * b.normal[2]);
}
}  // namespace

TwinIndex::TwinIndex(const std::vector<TwinPoint>& points, double cell_m) : points_(points), cell_m_(cell_m) {
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const TwinPoint& p = points[i];
    order_.emplace_back(key(cell_of(p[0], cell_m), cell_of(p[1], cell_m), cell_of(p[2], cell_m)), i);
  }
  std::sort(order_.begin(), order_.end());
}

std::uint64_t TwinIndex::key(std::int64_t x, std::int64_t y, std::int64_t z) const {
  const auto part = [](std::int64_t v) { return static_cast<std::uint64_t>(v + (1 << 20)); };
  return part(x) | part(y) << 21 | part(z) << 42;
}

std::pair<std::size_t, std::size_t> TwinIndex::row(const TwinPoint& p, std::int64_t dy,
                                                   std::int64_t dz) const {
  const std::int64_t x = cell_of(p[0], cell_m_);
  const std::int64_t y = cell_of(p[1], cell_m_) + dy;
  const std::int64_t z = cell_of(p[2], cell_m_) + dz;
  const auto begin = std::lower_bound(order_.begin(), order_.end(), std::pair{key(x - 1, y, z), 0u});
  const auto end = std::lower_bound(begin, order_.end(), std::pair{key(x + 2, y, z), 0u});
  return {static_cast<std::size_t>(begin - order_.begin()), static_cast<std::size_t>(end - order_.begin())};
}

std::vector<TwinNormal> twin_normals(const std::vector<TwinPoint>& points, double radius_m) {
  const TwinIndex index(points, radius_m);
  std::vector<TwinNormal> normals(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TwinPoint& p = points[i];
    double sum[3] = {};
    double square[3][3] = {};
    std::uint32_t n = 0;
    index.around(p, radius_m, [&](std::uint32_t k) {
      const double d[3] = {points[k][0] - p[0], points[k][1] - p[1], points[k][2] - p[2]};
      for (int r = 0; r < 3; ++r) {
        sum[r] += d[r];
        for (int c = 0; c < 3; ++c) square[r][c] += d[r] * d[c];
      }
      ++n;
    });
    normals[i].count = n;
    if (n < 3) continue;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) square[r][c] = square[r][c] / n - sum[r] / n * (sum[c] / n);
    }
    double values[3];
    jacobi(square, values, normals[i].normal);
    const double trace = values[0] + values[1] + values[2];
    normals[i].curvature = trace > 0 ? std::max(values[0], 0.0) / trace : 0;
    normals[i].gap = values[2] > 0 ? (values[1] - values[0]) / values[2] : 0;
  }
  return normals;
}

std::vector<std::uint32_t> twin_clusters(const std::vector<TwinPoint>& points, double radius_m) {
  const TwinIndex index(points, radius_m);
  Sets sets(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i)
    index.around(points[i], radius_m, [&](std::uint32_t k) {
      if (k < i) sets.unite(i, k);
    });
  std::vector<std::uint32_t> labels(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) labels[i] = sets.root(i);
  return labels;
}

std::vector<std::uint32_t> twin_surfaces(const std::vector<TwinPoint>& points,
                                         const std::vector<TwinNormal>& normals, double radius_m,
                                         double most_angle_rad, double most_curvature) {
  const TwinIndex index(points, radius_m);
  const double least = std::cos(most_angle_rad);
  const auto core = [&](std::uint32_t i) {
    return normals[i].count >= 3 && normals[i].curvature <= most_curvature;
  };
  Sets sets(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (!core(i)) continue;
    index.around(points[i], radius_m, [&](std::uint32_t k) {
      if (k < i && core(k) && like(normals[i], normals[k]) >= least) sets.unite(i, k);
    });
  }
  std::vector<std::uint32_t> labels(points.size(), kNoTwinLabel);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (core(i)) {
      labels[i] = sets.root(i);
      continue;
    }
    double best = least;
    if (normals[i].count < 3) continue;
    index.around(points[i], radius_m, [&](std::uint32_t k) {
      if (!core(k) || like(normals[i], normals[k]) < best) return;
      best = like(normals[i], normals[k]);
      labels[i] = sets.root(k);
    });
  }
  return labels;
}

double adjusted_rand(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  std::vector<std::uint32_t> of_a;
  std::vector<std::uint32_t> of_b;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i] == kNoTwinLabel || b[i] == kNoTwinLabel) continue;
    of_a.push_back(a[i]);
    of_b.push_back(b[i]);
  }
  return of_a.size() < 2 ? std::nan("") : adjusted_rand_index(of_a, of_b);
}

}  // namespace sortie::bench
