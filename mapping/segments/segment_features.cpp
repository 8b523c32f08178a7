// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/segments/segment_features.hpp"

#include <algorithm>
#include <cmath>

#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr double kSteps = 256.0;

/// Eigenvalues of a symmetric matrix, largest first: cyclic Jacobi rotations, a fixed number of sweeps.
void eigenvalues(double (&a)[3][3], double (&l)[3]) {
  constexpr int kPairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int sweep = 0; sweep < 8; ++sweep) {
    for (const auto& pair : kPairs) {
      const int p = pair[0];
      const int q = pair[1];
      const int r = 3 - p - q;
      if (a[p][q] == 0.0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
      const double root = std::sqrt(theta * theta + 1.0);
      const double t = std::isfinite(root) ? (theta < 0.0 ? -1.0 : 1.0) / (std::fabs(theta) + root) : 0.0;
      const double c = 1.0 / std::sqrt(t * t + 1.0);
      const double s = t * c;
      const double apr = a[p][r];
      const double aqr = a[q][r];
      a[p][p] -= t * a[p][q];
      a[q][q] += t * a[p][q];
      a[p][q] = a[q][p] = 0.0;
      a[p][r] = a[r][p] = c * apr - s * aqr;
      a[q][r] = a[r][q] = s * apr + c * aqr;
    }
  }
  for (int i = 0; i < 3; ++i) l[i] = std::max(a[i][i], 0.0);
  std::sort(l, l + 3, [](double x, double y) { return x > y; });
}
}  // namespace

void SegmentMoments::add(const std::int32_t (&at)[3]) {
  for (int i = 0; i < 3; ++i) {
    least[i] = count == 0 ? at[i] : std::min(least[i], at[i]);
    most[i] = count == 0 ? at[i] : std::max(most[i], at[i]);
    sum[i] += at[i];
    square[i] += std::int64_t{at[i]} * at[i];
  }
  product[0] += std::int64_t{at[0]} * at[1];
  product[1] += std::int64_t{at[0]} * at[2];
  product[2] += std::int64_t{at[1]} * at[2];
  ++count;
}

bool sum_segments(const RollingGrid& grid, const FragmentGraph& graph, const Labelling& labelling,
                  std::span<SegmentMoments> moments) {
  if (moments.size() < labelling.slots().size()) return false;
  std::fill(moments.begin(), moments.end(), SegmentMoments{});
  const BlockAt anchor = grid.centre();
  for (std::uint32_t i = 0; i < graph.numbers(); ++i) {
    const FragmentNode& node = graph[static_cast<NodeIndex>(i)];
    const std::uint16_t label = node.label[labelling.shown()];
    if (node.cells == 0 || label == kNoLabel) continue;
    const Block& block = grid.block(node.block);
    const BlockAt at = BlockAt::from_key(block.key);
    const std::int32_t corner[3] = {1024 * (at.x - anchor.x), 1024 * (at.y - anchor.y),
                                    1024 * (at.z - anchor.z)};
    for (std::uint64_t rest = node.cells; rest != 0; rest = without_lowest(rest)) {
      const unsigned cell = lowest(rest);
      const Centroid& c = grid.voxel(block, cell);
      moments[label].add({corner[0] + static_cast<std::int32_t>((cell & 3) << 8 | c.x >> 8),
                          corner[1] + static_cast<std::int32_t>((cell >> 2 & 3) << 8 | c.y >> 8),
                          corner[2] + static_cast<std::int32_t>((cell >> 4) << 8 | c.z >> 8)});
    }
  }
  return true;
}

SegmentFeatures features_of(const SegmentMoments& m, const BlockAt& anchor, double voxel_size_m) {
  SegmentFeatures f;
  if (m.count <= 0) return f;
  const double scale = voxel_size_m / kSteps;
  const double n = static_cast<double>(m.count);
  double mean[3];
  for (int i = 0; i < 3; ++i) mean[i] = static_cast<double>(m.sum[i]) / n;
  const double corner[3] = {4.0 * anchor.x, 4.0 * anchor.y, 4.0 * anchor.z};
  const auto place = [&corner, voxel_size_m](int axis, double steps) {
    return voxel_size_m * (corner[axis] + (steps + 0.5) / kSteps);
  };
  f.voxels = static_cast<std::uint32_t>(m.count);
  f.centroid_m = {place(0, mean[0]), place(1, mean[1]), place(2, mean[2])};
  f.least_m = {place(0, m.least[0]), place(1, m.least[1]), place(2, m.least[2])};
  f.most_m = {place(0, m.most[0]), place(1, m.most[1]), place(2, m.most[2])};
  const auto square = [&m, &mean, n](int i) {
    return static_cast<double>(m.square[i]) / n - mean[i] * mean[i];
  };
  const auto product = [&m, &mean, n](int at, int i, int k) {
    return static_cast<double>(m.product[at]) / n - mean[i] * mean[k];
  };
  const double xy = product(0, 0, 1);
  const double xz = product(1, 0, 2);
  const double yz = product(2, 1, 2);
  double a[3][3] = {{square(0), xy, xz}, {xy, square(1), yz}, {xz, yz, square(2)}};
  double l[3];
  eigenvalues(a, l);
  const double total = l[0] + l[1] + l[2];
  // Less than a thousandth of a step is what rounding leaves of points in one place.
  if (!(total > 1e-6)) return f;
  for (int i = 0; i < 3; ++i) {
    f.spread_m2[i] = l[i] * scale * scale;
    l[i] /= total;
    if (l[i] > 0.0) f.eigenentropy -= l[i] * rt::log(l[i]);
  }
  f.linearity = (l[0] - l[1]) / l[0];
  f.planarity = (l[1] - l[2]) / l[0];
  f.scattering = l[2] / l[0];
  f.anisotropy = (l[0] - l[2]) / l[0];
  const double volume = l[0] * l[1] * l[2];
  f.omnivariance = volume > 0.0 ? rt::exp(rt::log(volume) / 3.0) : 0.0;
  f.curvature_change = l[2];
  return f;
}

}  // namespace sortie::mapping
