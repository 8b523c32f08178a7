// SPDX-License-Identifier: BSD-3-Clause
// The cells that a ray passes, each one, in order: Amanatides and Woo's walk (1987) in integers.
//
// Consecutive cells share a face. Bresenham's line in three dimensions, which the published ray planner
// walks, goes from cell to cell over edges and corners as well: it passes through walls that are one cell
// thick and slanted, and misses up to two thirds of the cells on a diagonal.
#pragma once

#include <cstdint>

#include "mapping/occupancy/occupancy_view.hpp"
#include "rt/rotation.hpp"

namespace sortie::mapping {

/// Where a walk is. Distances along the ray are counts of 2^-22 voxels whose two lowest bits name the axis:
/// no two of them are equal, so the next face is always one, and ties (edges, corners) go x before y before
/// z. Rounding moves a crossing by less than 3e-4 voxels after 511 cells. A walk cannot leave its window.
struct VoxelWalk {
  static constexpr double kMostVoxels = 511.0;  ///< length of a walk
  static constexpr std::uint32_t kMost = 2044u << 20;

  std::uint32_t next[3];    ///< distance at which the ray leaves the cell along each axis
  std::uint32_t delta[3];   ///< distance between two faces of an axis
  std::uint32_t stride[3];  ///< change of the index at a face, modulo 2^32
  std::uint32_t end;        ///< the walk is over at the first face at or beyond
  std::uint32_t index;      ///< of the cell, in the window

  /// Goes to the next cell; false at the end.
  bool step() {
    std::uint32_t axis;
    return step(axis);
  }
  /// The same; `axis` is the one whose face was crossed.
  bool step(std::uint32_t& axis) {
    const std::uint32_t xy = next[0] < next[1] ? next[0] : next[1];
    const std::uint32_t nearest = xy < next[2] ? xy : next[2];
    if (nearest >= end) return false;
    axis = nearest & 3u;
    if (nearest == next[0]) {
      next[0] += delta[0];
      index += stride[0];
    } else if (nearest == next[1]) {
      next[1] += delta[1];
      index += stride[1];
    } else {
      next[2] += delta[2];
      index += stride[2];
    }
    return true;
  }
};

/// A walk from `u` (voxels from the window's low corner, inside it) along the unit vector `direction` for
/// `length` voxels (0 .. kMostVoxels) or to the window's edge.
inline VoxelWalk make_walk(const OccupancyView& view, const rt::Vector3& u, const rt::Vector3& direction,
                           double length) {
  constexpr double kScale = 1048576.0;  // 2^20; two more bits are the axis
  constexpr double kMostSteps = VoxelWalk::kMostVoxels * kScale;
  VoxelWalk walk;
  std::uint32_t end =
      static_cast<std::uint32_t>(length < VoxelWalk::kMostVoxels ? length * kScale : kMostSteps) << 2;
  const double start[3] = {u.x, u.y, u.z};
  const double along[3] = {direction.x, direction.y, direction.z};
  std::uint32_t stride = 1;
  walk.index = 0;
  for (std::uint32_t a = 0; a < 3; ++a) {
    const auto cell = static_cast<std::int32_t>(start[a]);
    const bool up = along[a] > 0;
    const double slope = up ? along[a] : -along[a];
    const double rest = up ? cell + 1 - start[a] : start[a] - cell;
    double first = kMostSteps;
    double delta = kMostSteps;
    if (slope > 1e-9) {
      const double scale = kScale / slope;
      delta = scale < kMostSteps ? scale : kMostSteps;
      first = rest * scale < kMostSteps ? rest * scale : kMostSteps;
    }
    walk.next[a] = static_cast<std::uint32_t>(first) << 2 | a;
    walk.delta[a] = static_cast<std::uint32_t>(delta + 0.5) << 2;
    walk.stride[a] = up ? stride : 0u - stride;
    walk.index += stride * static_cast<std::uint32_t>(cell);
    // The face through which the ray leaves the window: not crossed.
    const std::uint64_t inner = static_cast<std::uint64_t>(up ? view.size[a] - 1 - cell : cell);
    const std::uint64_t leaves = walk.next[a] + inner * walk.delta[a];
    if (leaves < end) end = static_cast<std::uint32_t>(leaves);
    stride *= static_cast<std::uint32_t>(view.size[a]);
  }
  walk.end = end;
  return walk;
}

}  // namespace sortie::mapping
