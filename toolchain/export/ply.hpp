// SPDX-License-Identifier: BSD-3-Clause
// Point clouds for MeshLab, CloudCompare and the like.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

#include "firmware_like/runtime/vehicle.hpp"

namespace sortie::toolchain {

/// One voxel: the mean of its points in the world, and how many there were.
struct CloudPoint {
  float x_m{};
  float y_m{};
  float z_m{};
  std::uint32_t hits{};
  std::uint32_t segment{};  ///< id; 0: of none
  float normal[3]{};        ///< unit vector; zero: none
  unsigned char red{128};
  unsigned char green{128};
  unsigned char blue{128};
};

/// A voxel as a point whose colour tells its segment: neighbours in number are far apart in hue; grey is of
/// none.
CloudPoint to_cloud_point(const firmware::VoxelOnMap& voxel);

/// Writes x, y, z (float, m), hits and segment (uint), red, green and blue (uchar) of each point, and nx, ny,
/// nz (float) where any point has a normal, little endian: 23 bytes a point, 35 with a normal. Points that
/// are not finite are left out. Returns the points written. Same input, same bytes.
std::size_t write_ply(std::ostream& out, std::span<const CloudPoint> points);

}  // namespace sortie::toolchain
