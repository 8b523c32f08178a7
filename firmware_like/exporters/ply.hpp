// SPDX-License-Identifier: BSD-3-Clause
// Point clouds for MeshLab, CloudCompare and the like.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>

namespace sortie::firmware {

/// One voxel: the mean of its points in the world, and how many there were.
struct CloudPoint {
  float x_m{};
  float y_m{};
  float z_m{};
  std::uint32_t hits{};
};

/// Binary is little endian: 16 bytes a point.
enum class PlyFormat { binary, ascii };

/// Writes x, y, z (float, m) and hits (uint) of each point. Points that are not finite are left out. Returns
/// the points written. Same input, same bytes.
std::size_t write_ply(std::ostream& out, std::span<const CloudPoint> points,
                      PlyFormat format = PlyFormat::binary);

}  // namespace sortie::firmware
