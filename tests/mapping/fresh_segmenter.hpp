// SPDX-License-Identifier: BSD-3-Clause
// A segmenter that kept up with a drive beside one that sees the map for the first time: larger worlds than
// brute force can judge, with surfaces whose normals waver.
#pragma once

#include <map>
#include <vector>

#include "tests/mapping/owned_map.hpp"
#include "tests/mapping/random_worlds.hpp"

namespace sortie::tests {

inline const MapSizes kFreshSizes{4096, 65536, 8192, 8192, 8192, 16384};

/// Floor, walls and clutter about a sensor that goes to and fro.
inline std::vector<rt::ScanPoint> wavering_scan(WorldRandom& random, const rt::Vector3& sensor) {
  std::vector<rt::ScanPoint> points;
  for (int i = 0; i < 1500; ++i) {
    const double x = random.between(-3, 3);
    const double y = random.between(-3, 3);
    const double noise = random.between(-0.015, 0.015);
    const std::uint32_t kind = random.below(8);
    rt::Vector3 p{x, y, noise - 0.8};
    if (kind == 1) p = {noise + 2.5, y, 0.3 * x};
    if (kind == 2) p = {x, noise - 2.0 + 0.1 * x * x, 0.3 * y};
    if (kind == 3) p = {x, y, 0.2 * x + 0.15 * y + noise};
    if (kind == 4) p = {x, y, random.between(-0.9, 1.2)};
    const rt::Vector3 d = p - sensor;
    points.push_back({static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z), 0, 0});
  }
  return points;
}

struct FreshVerdict {
  std::uint32_t cores{};
  std::uint32_t differing{};
};

/// Cores that the two put together otherwise.
template <class Policy>
void beside_fresh(const OwnedMap<Policy>& map, const Policy& policy, double radius_m, FreshVerdict& verdict,
                  const MapSizes& sizes = kFreshSizes) {
  const mapping::RollingGrid& grid = map.grid();
  mapping::SegmenterConfig config;
  config.radius_m = radius_m;
  config.min_voxels = 1;
  OwnedSegmenter<Policy> fresh(config, grid.config().voxel_size_m, sizes, policy);
  for (std::uint32_t i = 0; i < grid.block_numbers(); ++i) {
    const auto index = static_cast<mapping::BlockIndex>(i);
    if (grid.block(index).in_use()) fresh.segmenter.mark(index, grid.block(index).active);
  }
  (void)fresh.segmenter.update(grid, 1);
  std::map<std::uint32_t, std::uint32_t> there;
  std::map<std::uint32_t, std::uint32_t> back;
  for (const TwinVoxel& v : twin_voxels(grid)) {
    const mapping::Block& block = grid.block(v.block);
    if (!policy.core(policy.load(grid, block.slot(block.rank(v.cell))))) continue;
    const std::uint32_t a = map.segmenter().segment_of(grid, v.block, v.cell);
    const std::uint32_t b = fresh.segmenter.segment_of(grid, v.block, v.cell);
    ++verdict.cores;
    if (a == 0 || there.emplace(a, b).first->second != b || back.emplace(b, a).first->second != a)
      ++verdict.differing;
  }
}

template <class Policy>
FreshVerdict wavering_drive(std::uint32_t seed, const Policy& policy) {
  WorldRandom random(seed);
  mapping::RollingGridConfig grid;
  grid.min_range_m = 0;
  grid.radius_m = 2.2;
  grid.half_height_m = 1.5;
  mapping::SegmenterConfig config;
  config.radius_m = seed % 2 == 0 ? 0.2 : 0.15;
  config.min_voxels = 1;
  OwnedMap<Policy> map(grid, config, kFreshSizes, policy);
  FreshVerdict verdict;
  for (std::uint32_t tick = 0; tick < 60; ++tick) {
    const double way = tick < 30 ? 0.08 * tick : 0.08 * (60 - tick);
    const rt::Vector3 sensor{way - 1.2, 0.3 * way, 0};
    const std::vector<rt::ScanPoint> points = wavering_scan(random, sensor);
    (void)map.map.update(scan_over(points), {sensor, {}}, tick);
    beside_fresh(map, policy, config.radius_m, verdict);
  }
  return verdict;
}
}  // namespace sortie::tests
