// SPDX-License-Identifier: BSD-3-Clause
// What a batch makes of a map's voxels, in double and with no knowledge of blocks, fragments or history: the
// judge of normals and segments.
#pragma once

#include <cstdint>
#include <vector>

#include "mapping/rolling_grid.hpp"

namespace sortie::bench {

/// An active voxel, in the grid's frame, metres.
struct BatchVoxel {
  mapping::BlockIndex block{};
  unsigned cell{};
  rt::Vector3 p_m;
  rt::Vector3 normal;  ///< what the map holds; zero: none
};

/// A normal by a batch: of the smallest eigenvalue of the neighbours' covariance.
struct BatchNormal {
  rt::Vector3 normal;  ///< zero: fewer than three neighbours
  double curvature{};  ///< smallest eigenvalue over the sum of all
  double margin{};     ///< (middle - smallest) / largest: below 0.05 the normal is hardly defined
};

/// All active voxels of a map, by a walk over all blocks and cells.
std::vector<BatchVoxel> active_voxels(const mapping::RollingGrid& grid);

/// Pairs of voxels nearer than a radius, by a hash of cells of that radius. Memory: linear.
class Neighbours {
 public:
  Neighbours(const std::vector<BatchVoxel>& voxels, double radius_m);
  /// Calls `use(other)` for all voxels within the radius of `voxel`, itself among them.
  template <class Use>
  void around(std::size_t voxel, Use use) const {
    around_(
        voxel, [](void* self, std::size_t other) { (*static_cast<Use*>(self))(other); }, &use);
  }

 private:
  using Call = void (*)(void*, std::size_t);
  void around_(std::size_t voxel, Call call, void* self) const;

  const std::vector<BatchVoxel>* voxels_;
  double radius_m_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> sorted_;  // cell, voxel
};

/// Normals of all voxels over the current means, in double.
std::vector<BatchNormal> batch_normals(const std::vector<BatchVoxel>& voxels, double radius_m);

/// Components of what is near enough. Each voxel's label is the least index of its component.
std::vector<std::uint32_t> euclidean_batch(const std::vector<BatchVoxel>& voxels, double radius_m);

/// Components of flat voxels that are near enough and whose normals differ by little; others stand alone.
std::vector<std::uint32_t> smooth_batch(const std::vector<BatchVoxel>& voxels,
                                        const std::vector<BatchNormal>& normals, double radius_m,
                                        double most_angle_rad, double most_curvature);

}  // namespace sortie::bench
