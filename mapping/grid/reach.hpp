// SPDX-License-Identifier: BSD-3-Clause
// Which cells can hold a point within a radius of a point in a given cell: masks for a block and the 26
// around it, and the exact test in whole numbers that decides the rest.
#pragma once

#include <cstdint>

#include "mapping/grid/block.hpp"

namespace sortie::mapping {

/// A voxel's mean relative to the corner of some block, in whole 1/65536 of a cell.
struct UnitPoint {
  std::int32_t x;
  std::int32_t y;
  std::int32_t z;
};

constexpr UnitPoint unit_point(const Centroid& c, unsigned cell) {
  return {static_cast<std::int32_t>((cell & 3) << 16 | c.x),
          static_cast<std::int32_t>((cell >> 2 & 3) << 16 | c.y),
          static_cast<std::int32_t>((cell >> 4) << 16 | c.z)};
}

/// The same point of the block in `direction`, relative to the corner of the block in the middle.
constexpr UnitPoint from_next(const UnitPoint& p, int direction) {
  constexpr std::int32_t kBlock = 4 << 16;
  const BlockAt& step = kDirectionSteps.to[direction];
  return {p.x + step.x * kBlock, p.y + step.y * kBlock, p.z + step.z * kBlock};
}

constexpr std::int64_t squared_distance(const UnitPoint& a, const UnitPoint& b) {
  const std::int64_t x = a.x - b.x;
  const std::int64_t y = a.y - b.y;
  const std::int64_t z = a.z - b.z;
  return x * x + y * y + z * z;
}

/// Masks for one radius, at most 4 cells: then only the 26 blocks around matter. 14 kB.
class Reach {
 public:
  static constexpr double kMostCells = 4.0;

  /// A radius outside (0, 4] cells reaches nothing.
  explicit Reach(double radius_cells);

  /// Cells of the block in `direction` that can hold a point within the radius of one in `cell`; for the
  /// block itself without `cell`.
  std::uint64_t from(unsigned cell, int direction) const { return cells_[direction][cell]; }
  /// Of those in the block itself the cells that touch, where most that is near is found, and those that
  /// share a face.
  std::uint64_t close(unsigned cell) const { return close_[cell]; }
  std::uint64_t beside(unsigned cell) const { return beside_[cell]; }
  /// Cells from which anything in that direction can be reached.
  std::uint64_t rim(int direction) const { return rim_[direction]; }
  /// Greatest squared distance that counts as near, exactly: whole numbers on both sides.
  std::int64_t squared_radius() const { return squared_radius_; }
  bool near(const UnitPoint& a, const UnitPoint& b) const {
    return squared_distance(a, b) <= squared_radius_;
  }

 private:
  std::uint64_t cells_[kDirections][Block::kCells]{};
  std::uint64_t close_[Block::kCells]{};
  std::uint64_t beside_[Block::kCells]{};
  std::uint64_t rim_[kDirections]{};
  std::int64_t squared_radius_{-1};
};

}  // namespace sortie::mapping
