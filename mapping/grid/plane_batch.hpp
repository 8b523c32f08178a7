// SPDX-License-Identifier: BSD-3-Clause
// Normals and curvature of a block's voxels at once, from the sums over their neighbours: the smallest
// eigenvalue of each 3x3 matrix without trigonometry, heap or a loop without end, in loops that a compiler
// turns into vectors.
#pragma once

#include <cstdint>

#include "mapping/grid/normal_record.hpp"

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

/// n^2 times the covariance of what a record sums up. Exact: whole numbers below 2^53.
inline Symmetric3 scaled_covariance(const NormalSums& r) {
  const auto n = static_cast<std::int64_t>(r.count);
  const std::int64_t sum[3] = {r.sum.x(), r.sum.y(), r.sum.z()};
  const auto square = [&](int i) { return static_cast<double>(n * r.square[i] - sum[i] * sum[i]); };
  const auto product = [&](int at, int i, int k) {
    return static_cast<double>(n * r.product[at] - sum[i] * sum[k]);
  };
  return {square(0), square(1), square(2), product(0, 0, 1), product(1, 0, 2), product(2, 1, 2)};
}

/// Up to 64 planes. Covariances are exact until they are divided by their trace; from there on single
/// precision is enough: where (l1 - l0) / l2 > 0.05 a normal is off by less than 0.01 degrees and the
/// curvature by less than 1e-4; where all three are nearly one, curvature by less than 0.02. The same bits
/// everywhere: sums, products, quotients and roots alone.
class PlaneBatch {
 public:
  static constexpr unsigned kMost = 64;

  /// Takes a matrix in, to be solved next. An empty one (all points in one place) has no normal.
  void add(const Symmetric3& covariance);
  unsigned size() const { return size_; }
  /// Fits all planes.
  void solve();
  /// Normal and curvature of the n-th one. Unit length; of all points on a line, square to it. The sign is
  /// such that the first of z, y, x that is not 0 is positive.
  SurfaceNormal plane(unsigned n) const;
  /// The same normal before it was rounded.
  float normal(int axis, unsigned n) const { return normal_[axis][n / kLanes][n % kLanes]; }
  /// Smallest eigenvalue over the trace, [0, 1/3].
  float curvature(unsigned n) const { return least_[n / kLanes][n % kLanes]; }

 private:
  /// Four numbers that every operation is done on at once, where the processor can; the same bits where not.
  static constexpr unsigned kLanes = 4;
  using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
  static constexpr unsigned kMostLanes = kMost / kLanes;

  unsigned lanes() const { return (size_ + kLanes - 1) / kLanes; }
  void find_least();
  void find_normals();
  void mend(unsigned n);

  unsigned size_{};
  std::uint64_t empty_{};
  Lanes xx_[kMostLanes];
  Lanes yy_[kMostLanes];
  Lanes zz_[kMostLanes];
  Lanes xy_[kMostLanes];
  Lanes xz_[kMostLanes];
  Lanes yz_[kMostLanes];
  Lanes minors_[kMostLanes];  ///< sum of the three principal minors
  Lanes determinant_[kMostLanes];
  Lanes most_[kMostLanes];  ///< what the smallest eigenvalue cannot exceed
  Lanes least_[kMostLanes];
  Lanes longest_[kMostLanes];
  Lanes normal_[3][kMostLanes];
};

}  // namespace sortie::mapping
