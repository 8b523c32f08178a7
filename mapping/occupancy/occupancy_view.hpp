// SPDX-License-Identifier: BSD-3-Clause
// What others see of the occupancy map: a window of cells, each one byte of log-odds.
#pragma once

#include <cstdint>

#include "rt/rotation.hpp"

namespace sortie::mapping {

/// One step of a cell's log-odds, in nats. 127 steps reach probabilities of 7.8e-8 and 1 - 7.8e-8; half a
/// step is an error of 6.4 % in the odds.
inline constexpr double kLogOddsStep = 33.0 / 256.0;
/// Most steps that a cell counts; it saturates there.
inline constexpr int kLogOddsLimit = 127;
/// A cell that nothing was measured in. It stands for the prior.
inline constexpr std::int8_t kUnknownCell = -128;

/// Index of a cell's code in tables of 256.
constexpr std::uint32_t cell_code(std::int8_t cell) { return static_cast<std::uint8_t>(cell); }

/// A box of cells, x fastest, then y, then z. The cells belong to the map and change with it.
struct OccupancyView {
  const std::int8_t* cells{};
  std::int32_t size[3]{};  ///< cells along x, y, z
  std::int32_t low[3]{};   ///< world number of the first cell: it spans low .. low + 1 in voxels
  double voxel_size_m{};
  std::uint64_t cell_count() const {
    return static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1]) *
           static_cast<std::uint64_t>(size[2]);
  }
  /// A world point in voxels from the window's low corner.
  rt::Vector3 to_window(const rt::Vector3& p_world_m) const {
    const double s = 1.0 / voxel_size_m;
    return {s * p_world_m.x - low[0], s * p_world_m.y - low[1], s * p_world_m.z - low[2]};
  }
  /// True when a point in voxels from the low corner lies in the window; false for a NaN.
  bool contains(const rt::Vector3& u) const {
    return u.x >= 0 && u.x < size[0] && u.y >= 0 && u.y < size[1] && u.z >= 0 && u.z < size[2];
  }
};

}  // namespace sortie::mapping
