// SPDX-License-Identifier: BSD-3-Clause
// PLY 1.0 with one element.
#include "toolchain/export/ply.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <ostream>
#include <string>

namespace sortie::toolchain {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");

bool finite(const CloudPoint& p) {
  return std::isfinite(p.x_m) && std::isfinite(p.y_m) && std::isfinite(p.z_m);
}

bool has_normal(const CloudPoint& p) { return p.normal[0] != 0 || p.normal[1] != 0 || p.normal[2] != 0; }

/// Of a hue in 1/1536 of the circle, fully saturated.
void set_hue(std::uint32_t hue, CloudPoint& point) {
  const std::uint32_t part = hue / 256;
  const auto up = static_cast<unsigned char>(hue % 256);
  const auto down = static_cast<unsigned char>(255 - up);
  const unsigned char table[6][3] = {{255, up, 0},   {down, 255, 0}, {0, 255, up},
                                     {0, down, 255}, {up, 0, 255},   {255, 0, down}};
  point.red = table[part][0];
  point.green = table[part][1];
  point.blue = table[part][2];
}

template <class T>
void put(std::ostream& out, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.write(bytes, sizeof bytes);
}

void write_bytes(std::ostream& out, const CloudPoint& p, bool normals) {
  for (const float part : {p.x_m, p.y_m, p.z_m}) put(out, part);
  put(out, p.hits);
  put(out, p.segment);
  for (const unsigned char part : {p.red, p.green, p.blue}) put(out, part);
  if (normals) {
    for (const float part : p.normal) put(out, part);
  }
}

}  // namespace

CloudPoint to_cloud_point(const firmware::VoxelOnMap& voxel) {
  CloudPoint point;
  point.x_m = static_cast<float>(voxel.p_world_m[0]);
  point.y_m = static_cast<float>(voxel.p_world_m[1]);
  point.z_m = static_cast<float>(voxel.p_world_m[2]);
  point.hits = voxel.count;
  point.segment = voxel.segment;
  for (int i = 0; i < 3; ++i) point.normal[i] = static_cast<float>(voxel.normal_world[i]);
  // Steps of the golden section of the circle.
  if (voxel.segment != 0) set_hue(voxel.segment * 949u % 1536u, point);
  return point;
}

std::size_t write_ply(std::ostream& out, std::span<const CloudPoint> points) {
  const auto count = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), finite));
  const bool normals = std::any_of(points.begin(), points.end(), has_normal);
  out << "ply\nformat binary_little_endian 1.0\ncomment metres, world frame\nelement vertex "
      << std::to_string(count)
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty uint hits\nproperty uint segment"
         "\nproperty uchar red\nproperty uchar green\nproperty uchar blue";
  if (normals) out << "\nproperty float nx\nproperty float ny\nproperty float nz";
  out << "\nend_header\n";
  for (const CloudPoint& point : points) {
    if (finite(point)) write_bytes(out, point, normals);
  }
  return count;
}

}  // namespace sortie::toolchain
