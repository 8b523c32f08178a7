// SPDX-License-Identifier: BSD-3-Clause
// The volume that a voxel map calls occupied, and how far two maps of different voxel size agree on it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "firmware_like/runtime/runtime.hpp"

namespace sortie::toolchain {

/// Occupied voxels of a map as sorted cell numbers. Memory: 8 bytes a voxel.
struct MapVolume {
  double voxel_m{};
  std::uint64_t refused{};  ///< points that found the pool full: the map is not whole
  std::vector<std::uint64_t> cells;

  double volume_m3() const { return static_cast<double>(cells.size()) * voxel_m * voxel_m * voxel_m; }
};

/// The map as a replay left it; nothing if the vehicle has no map or no key map.voxel_m.
std::optional<MapVolume> map_volume(const firmware::Runtime& runtime);

/// How far `map` and `reference` agree.
struct MapAgreement {
  double disagreement{};  ///< 1 - common volume / volume of either: 0 = the same, 1 = nothing in common
  double missed{};        ///< share of the reference's volume that `map` calls free
  double excess{};        ///< volume that `map` alone calls occupied, in volumes of the reference
};

/// Compares at the centres of the reference's voxels: exact where the voxel size of `map` is a whole multiple
/// of the reference's. It judges volume, not truth: a coarse voxel holds much air even where its surface is
/// right.
MapAgreement compare_volumes(const MapVolume& map, const MapVolume& reference);

}  // namespace sortie::toolchain
