// SPDX-License-Identifier: BSD-3-Clause
// A recorded place as a world to look at: the cells in which its scans have points.
#pragma once

#include <cstdint>
#include <span>

#include "hil/world.hpp"

namespace sortie::hil {

/// A box of cells, each solid or not, in the caller's memory; outside of it there is nothing. What no scan
/// has seen is open: rays pass through holes of the recording. After the last add() all is const.
class VoxelWorld {
 public:
  static constexpr std::uint16_t kReflectivity = 100;

  /// Words that a box of `size` cells asks for.
  static std::uint64_t words(const std::int32_t (&size)[3]);
  /// `low_m`: the box's low corner. `bits`: words(size) of them, zeroed here. usable() is false when a size
  /// is not in 1..4096, the edge of a cell not in 1 mm..100 m, or there are too few words.
  VoxelWorld(double voxel_m, const Vec3& low_m, const std::int32_t (&size)[3], std::span<std::uint32_t> bits);
  bool usable() const { return usable_; }

  /// Makes the cell of a point solid. Status: ok; out_of_range (outside the box, or no number).
  Status add(const Vec3& point_m);
  /// Cells that are solid.
  std::uint64_t solids() const { return solids_; }
  bool solid(std::int32_t x, std::int32_t y, std::int32_t z) const;

  /// The first solid cell that a ray meets within `max_range_m`; `direction` has length 1. The range is to
  /// the middle of the ray's way through the cell: the points lie within, not on its faces. A ray that begins
  /// in a solid cell has range 0. Exact (Amanatides and Woo 1987, face to face). Cost: 3 ns a cell.
  Hit cast(const Vec3& origin_m, const Vec3& direction, double max_range_m) const;

 private:
  std::uint64_t bit_of(std::int32_t x, std::int32_t y, std::int32_t z) const;

  double voxel_m_{1};
  Vec3 low_m_;
  std::int32_t size_[3]{};
  std::span<std::uint32_t> bits_;
  std::uint64_t solids_{};
  bool usable_{};
};

}  // namespace sortie::hil
