// SPDX-License-Identifier: BSD-3-Clause
// What a coarse cell of the map knows of the surface in it: sums over its points in whole numbers, the
// Gaussian that they make, and both as they are kept, in a state or in a map file.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// Points in a cell are whole 1/4096 of its edge from its centre (0.1 mm for 0.4 m).
inline constexpr std::int32_t kSurfelSteps = 4096;

/// Points that a cell's sums have room for: (4096 / 2)^2 * 32768 < 2^38.
inline constexpr std::uint32_t kMostSurfelPoints = 32'768;

/// Sums over the points of a cell, exact and in any order the same. 64 bytes.
struct SurfelSums {
  std::int64_t product[6]{};  ///< xx, yy, zz, xy, xz, yz
  std::int32_t sum[3]{};
  std::uint32_t count{};
  SORTIE_FIELDS(product, sum, count)

  void add(const std::int32_t (&at)[3]) {
    const std::int64_t x = at[0], y = at[1], z = at[2];
    product[0] += x * x, product[1] += y * y, product[2] += z * z;
    product[3] += x * y, product[4] += x * z, product[5] += y * z;
    for (int i = 0; i < 3; ++i) sum[i] += at[i];
    ++count;
  }
  void add(const SurfelSums& other) {
    for (int i = 0; i < 6; ++i) product[i] += other.product[i];
    for (int i = 0; i < 3; ++i) sum[i] += other.sum[i];
    count += other.count;
  }
  /// Half of everything: what is new counts more from now on. Of an odd number of points the sums keep their
  /// share, to the step, so that mean and covariance stay what they were.
  void fade();
};
static_assert(sizeof(SurfelSums) == 64);

/// The same points in a cell twice as wide that this one is an eighth of; `upper`: its upper half, along each
/// axis. Sums are rounded to the wider cell's steps. Of more points than an eighth of what it has room for
/// every eighth keeps a share.
SurfelSums widened(SurfelSums sums, const bool (&upper)[3]);

/// The Gaussian of a cell, relative to its centre. 64 bytes.
struct Surfel {
  float mean_m[3]{};
  float axis[3][3]{};      ///< unit vectors, by rising variance: axis[0] is the normal of a flat one, and
                           ///< points to where it was seen from
  float variance_m2[3]{};  ///< along the axes
  std::uint32_t count{};   ///< points it was made of; 0: none yet

  rt::Vector3 mean() const { return vector_of(mean_m); }
  rt::Vector3 along(int i) const { return vector_of(axis[i]); }
  double variance(int i) const { return static_cast<double>(variance_m2[i]); }
  rt::Vector3 normal() const { return along(0); }
  SORTIE_FIELDS(mean_m, axis, variance_m2, count)

 private:
  static rt::Vector3 vector_of(const float (&v)[3]) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
  }
};
static_assert(sizeof(Surfel) == 64);

/// Of a cell's edge: standard deviation, across it, of a surface that is thin.
inline constexpr double kThinSurface = 0.075;
/// Points: of fewer, rows of a lidar that cross an edge may make a surface that is none.
inline constexpr std::uint32_t kSureSurface = 16;

/// Whether a cell's points lie on a surface and not along a line, which has no normal. `cell_m`: the edge.
inline bool is_surface(const Surfel& surfel, double cell_m) {
  constexpr double kLine = 4.0;  ///< times the least variance, or of the edge squared, the middle one has
  constexpr double kThinLine = 0.0036;
  return surfel.variance(1) >= kLine * surfel.variance(0) &&
         surfel.variance(1) >= kThinLine * cell_m * cell_m;
}

/// Squared distance of a point from a surfel in standard deviations, with noise added to each; the point
/// relative to the cell's centre.
inline double squared_deviations(const Surfel& surfel, const rt::Vector3& at_m, double noise_m2) {
  const rt::Vector3 off = at_m - surfel.mean();
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double along = rt::dot(surfel.along(i), off);
    sum += along * along / (surfel.variance(i) + noise_m2);
  }
  return sum;
}

/// The Gaussian of some sums in cells of an edge, m. At least one point. `planar`: the points stand for walls
/// that go upwards through the whole cell.
Surfel surfel_of(const SurfelSums& sums, double cell_m, bool planar = false);

/// A surfel with its cell. 136 bytes in canonical form.
struct SurfelRecord {
  static constexpr std::uint64_t kOtherSide = std::uint64_t{1} << 63;
  std::uint64_t key{};  ///< SurfelCell::key(), and kOtherSide of the surfel of a surface's other side
  SurfelSums sums;
  Surfel surfel;
  SORTIE_FIELDS(key, sums, surfel)
};

/// Null where the record can be one of a layer with cells of an edge, m; else a static text that says what
/// cannot be. After null no sum overflows, and the Gaussian is finite and lies in its cell. `sides`: the
/// layer keeps both sides of a surface.
const char* fault_of(const SurfelRecord& record, double cell_m, bool sides);

}  // namespace sortie::mapping
