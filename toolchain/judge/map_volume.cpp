// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/map_volume.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sortie::toolchain {

namespace {

constexpr int kBits = 21;
constexpr std::int64_t kHalf = std::int64_t{1} << (kBits - 1);
constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;

std::uint64_t pack(double x, double y, double z, double voxel_m) {
  std::uint64_t key = 0;
  for (const double value : {x, y, z}) {
    const double index =
        std::clamp(std::floor(value / voxel_m), static_cast<double>(-kHalf), static_cast<double>(kHalf - 1));
    key = (key << kBits) | static_cast<std::uint64_t>(static_cast<std::int64_t>(index) + kHalf);
  }
  return key;
}

double centre(std::uint64_t key, int axis, double voxel_m) {
  const auto index = static_cast<std::int64_t>((key >> (kBits * (2 - axis))) & kMask) - kHalf;
  return (static_cast<double>(index) + 0.5) * voxel_m;
}

}  // namespace

std::optional<MapVolume> map_volume(const firmware::Runtime& runtime) {
  MapVolume volume;
  for (const firmware::ProfileKey& key : runtime.profile().keys()) {
    if (key.path == "map.voxel_m") volume.voxel_m = std::strtod(key.value.c_str(), nullptr);
  }
  if (!(volume.voxel_m > 0)) return std::nullopt;
  runtime.vehicle().for_each_voxel([&volume](const firmware::VoxelOnMap& voxel) {
    volume.cells.push_back(pack(voxel.p_world_m[0], voxel.p_world_m[1], voxel.p_world_m[2], volume.voxel_m));
  });
  if (volume.cells.empty()) return std::nullopt;
  std::sort(volume.cells.begin(), volume.cells.end());
  // A centroid on the edge of its voxel may be rounded into the neighbour.
  volume.cells.erase(std::unique(volume.cells.begin(), volume.cells.end()), volume.cells.end());
  for (const auto& [name, level] : runtime.parts().pools()) {
    if (name == "voxels") volume.refused = level().refused;
  }
  return volume;
}

MapAgreement compare_volumes(const MapVolume& map, const MapVolume& reference) {
  std::uint64_t common = 0;
  for (const std::uint64_t key : reference.cells) {
    const std::uint64_t there = pack(centre(key, 0, reference.voxel_m), centre(key, 1, reference.voxel_m),
                                     centre(key, 2, reference.voxel_m), map.voxel_m);
    if (std::binary_search(map.cells.begin(), map.cells.end(), there)) ++common;
  }
  const double edge = reference.voxel_m;
  const double common_m3 = static_cast<double>(common) * edge * edge * edge;
  const double either_m3 = map.volume_m3() + reference.volume_m3() - common_m3;
  MapAgreement agreement;
  if (either_m3 > 0) agreement.disagreement = std::max(0.0, 1 - common_m3 / either_m3);
  if (reference.volume_m3() > 0) {
    agreement.missed = 1 - common_m3 / reference.volume_m3();
    agreement.excess = std::max(0.0, map.volume_m3() - common_m3) / reference.volume_m3();
  }
  return agreement;
}

}  // namespace sortie::toolchain
