// SPDX-License-Identifier: BSD-3-Clause
// The same results from scratch, in double, by other means than the map's: what the sweep calls right.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace sortie::bench {

using TwinPoint = std::array<double, 3>;
inline constexpr std::uint32_t kNoTwinLabel = 0xffffffffu;

/// Points sorted into cells as wide as the greatest distance asked for.
class TwinIndex {
 public:
  TwinIndex(const std::vector<TwinPoint>& points, double cell_m);

  /// Calls `see(index)` for all points within `radius_m` (at most the cell) of one, itself among them.
  template <class See>
  void around(const TwinPoint& p, double radius_m, const See& see) const {
    for (std::int64_t dz = -1; dz <= 1; ++dz) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        // Cells along x lie one after the other.
        const auto [begin, end] = row(p, dy, dz);
        for (std::size_t i = begin; i < end; ++i) {
          const TwinPoint& q = points_[order_[i].second];
          const double x = q[0] - p[0];
          const double y = q[1] - p[1];
          const double z = q[2] - p[2];
          if (x * x + y * y + z * z <= radius_m * radius_m) see(order_[i].second);
        }
      }
    }
  }

 private:
  std::pair<std::size_t, std::size_t> row(const TwinPoint& p, std::int64_t dy, std::int64_t dz) const;
  std::uint64_t key(std::int64_t x, std::int64_t y, std::int64_t z) const;

  const std::vector<TwinPoint>& points_;
  double cell_m_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order_;  ///< cell and point, sorted
};

/// Normal and curvature of a point; a count below 3: none.
struct TwinNormal {
  TwinPoint normal{};
  double curvature{};
  double gap{};  ///< (l1 - l0) / l2
  std::uint32_t count{};
};

/// Normals over all points within a radius. Eigenvectors by Jacobi's rotations.
std::vector<TwinNormal> twin_normals(const std::vector<TwinPoint>& points, double radius_m);

/// Connected components of all points within a radius of one another.
std::vector<std::uint32_t> twin_clusters(const std::vector<TwinPoint>& points, double radius_m);

/// Those of flat points with like normals; other points go to the flat one beside them with the nearest
/// normal, if that is near enough, or have no label.
std::vector<std::uint32_t> twin_surfaces(const std::vector<TwinPoint>& points,
                                         const std::vector<TwinNormal>& normals, double radius_m,
                                         double most_angle_rad, double most_curvature);

/// Adjusted Rand index of two labellings of the same things: 1 when they are the same, about 0 by chance.
/// Things without a label in either are left out.
double adjusted_rand(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b);

}  // namespace sortie::bench
