// SPDX-License-Identifier: BSD-3-Clause
// Small random worlds for the local map, and brute-force twins that know nothing of blocks, fragments or
// time.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <vector>

#include "tests/mapping/owned_map.hpp"
#include "tests/mapping/world_random.hpp"

namespace sortie::tests {

/// An active voxel as a twin sees it: whole coordinates in the grid, 65,536 a cell.
struct TwinVoxel {
  mapping::BlockIndex block{};
  unsigned cell{};
  std::int64_t cell_at[3]{};
  std::int64_t at[3]{};
};

/// All active voxels, by a walk over all blocks and cells.
inline std::vector<TwinVoxel> twin_voxels(const mapping::RollingGrid& grid) {
  std::vector<TwinVoxel> all;
  for (std::uint32_t i = 0; i < grid.block_numbers(); ++i) {
    const mapping::Block& block = grid.block(static_cast<mapping::BlockIndex>(i));
    if (!block.in_use()) continue;
    const mapping::BlockAt corner = mapping::BlockAt::from_key(block.key);
    for (unsigned cell = 0; cell < 64; ++cell) {
      if ((block.active >> cell & 1) == 0) continue;
      const mapping::Centroid& c = grid.voxel(block, cell);
      TwinVoxel v{static_cast<mapping::BlockIndex>(i), cell, {}, {}};
      const std::int32_t corners[3] = {corner.x, corner.y, corner.z};
      const unsigned cells[3] = {cell % 4, cell / 4 % 4, cell / 16};
      const std::uint16_t offsets[3] = {c.x, c.y, c.z};
      for (int axis = 0; axis < 3; ++axis) {
        v.cell_at[axis] = std::int64_t{4} * corners[axis] + cells[axis];
        v.at[axis] = v.cell_at[axis] * 65536 + offsets[axis];
      }
      all.push_back(v);
    }
  }
  return all;
}

/// Components of a graph that is given by its vertices and a test of pairs: the number of the smallest
/// member.
template <class Joined>
std::vector<std::size_t> twin_components(std::size_t size, Joined joined) {
  std::vector<std::size_t> parent(size);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&parent](std::size_t i) {
    while (parent[i] != i) i = parent[i];
    return i;
  };
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!joined(i, k)) continue;
      const std::size_t a = root(i);
      const std::size_t b = root(k);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < size; ++i) parent[i] = root(i);
  return parent;
}

inline bool twin_near(const TwinVoxel& a, const TwinVoxel& b, double radius_cells) {
  double sum = 0;  // whole numbers below 2^53
  for (int axis = 0; axis < 3; ++axis) {
    const auto d = static_cast<double>(a.at[axis] - b.at[axis]);
    sum += d * d;
  }
  return sum <= radius_cells * 65536.0 * (radius_cells * 65536.0);
}

/// True when two labellings of the same things are the same partition.
inline bool same_partition(const std::vector<std::size_t>& a, const std::vector<std::uint32_t>& b) {
  std::map<std::size_t, std::uint32_t> there;
  std::map<std::uint32_t, std::size_t> back;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!there.emplace(a[i], b[i]).second && there[a[i]] != b[i]) return false;
    if (!back.emplace(b[i], a[i]).second && back[b[i]] != a[i]) return false;
  }
  return true;
}

/// Settings of one random world: radii from half a voxel to four, eviction, forgetting and means that drift.
struct RandomWorld {
  mapping::RollingGridConfig grid;
  mapping::SegmenterConfig segmenter;
  mapping::NormalsConfig normals;
  rt::Vector3 sensor;

  explicit RandomWorld(WorldRandom& random) {
    grid.min_range_m = 0;
    grid.radius_m = random.between(1.0, 2.0);
    grid.half_height_m = 1.5;
    grid.min_points = 1 + random.below(3);
    grid.mean_window = random.below(2) == 0 ? 65535 : 1 + random.below(5);
    grid.forget_ticks = random.below(2) == 0 ? 0 : 3 + random.below(5);
    segmenter.radius_m = grid.voxel_size_m * random.between(0.5, 4.0);
    segmenter.min_voxels = 1;
    normals.radius_m = grid.voxel_size_m * random.between(1.0, 4.0);
    normals.restate_m = random.between(0.0, 0.1);
    sensor = {random.between(-5, 5), random.between(-5, 5), 0};
  }

  /// The robot goes on, and sees clutter, planes on the faces of blocks, and points on corners of cells.
  std::vector<rt::ScanPoint> next_scan(WorldRandom& random) {
    sensor.x += random.between(-0.4, 0.6);
    sensor.y += random.between(-0.3, 0.4);
    std::vector<rt::ScanPoint> points(random.below(120));
    for (rt::ScanPoint& p : points) {
      const std::uint32_t kind = random.below(3);
      if (kind == 0) {
        p.x_m = random.coordinate(-1.5, 1.5);
        p.y_m = random.coordinate(-1.5, 1.5);
        p.z_m = random.coordinate(-0.5, 0.5);
      } else if (kind == 1) {
        p.x_m = random.coordinate(-1.5, 1.5);
        p.y_m = static_cast<float>(0.4 * random.below(6) - 1.2 - sensor.y);
        p.z_m = random.coordinate(-0.2, 0.2);
      } else {
        p.x_m = static_cast<float>(0.1 * random.below(20) - 1.0 - std::fmod(sensor.x, 0.1));
        p.y_m = static_cast<float>(0.1 * random.below(20) - 1.0 - std::fmod(sensor.y, 0.1));
        p.z_m = static_cast<float>(0.1 * random.below(6) - 0.3);
      }
    }
    return points;
  }
};

inline rt::PointScan scan_over(const std::vector<rt::ScanPoint>& points) {
  rt::PointScan scan;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return scan;
}

/// What a run over random worlds found.
struct WorldVerdict {
  std::uint32_t ticks{};
  std::uint32_t wrong{};          ///< ticks with another partition than the twin's
  std::uint32_t not_current{};    ///< ticks after which something was left to do
  std::uint32_t most_segments{};  ///< in one tick
  std::uint64_t evicted{};        ///< voxels
  std::uint64_t cut{};            ///< segments born by a split
  std::uint64_t renamed{};
};

/// Euclidean maps in worlds `first` .. `first` + `worlds` - 1, compared with brute force after every tick.
inline WorldVerdict euclidean_worlds(std::uint32_t first, std::uint32_t worlds, std::uint32_t ticks) {
  WorldVerdict verdict;
  for (std::uint32_t seed = first; seed < first + worlds; ++seed) {
    WorldRandom random(seed);
    RandomWorld world(random);
    EuclideanMap map(world.grid, world.segmenter, MapSizes{});
    for (std::uint32_t tick = 0; tick < ticks; ++tick) {
      const std::vector<rt::ScanPoint> points = world.next_scan(random);
      const mapping::LocalMapStep step = map.map.update(scan_over(points), {world.sensor, {}}, tick);
      const std::vector<TwinVoxel> voxels = twin_voxels(map.grid());
      const std::vector<std::size_t> twin = twin_components(voxels.size(), [&](std::size_t a, std::size_t b) {
        return twin_near(voxels[a], voxels[b], world.segmenter.radius_m / world.grid.voxel_size_m);
      });
      std::vector<std::uint32_t> ids;
      for (const TwinVoxel& v : voxels)
        ids.push_back(map.segmenter().segment_of(map.grid(), v.block, v.cell));
      ++verdict.ticks;
      if (!same_partition(twin, ids)) ++verdict.wrong;
      if (!step.segments.current) ++verdict.not_current;
      verdict.most_segments = std::max(verdict.most_segments, map.segmenter().labelling().components());
    }
    verdict.evicted += map.grid().output().points.evicted;
    verdict.cut += map.segmenter().labelling().counts().cut;
    verdict.renamed += map.segmenter().labelling().counts().renamed;
  }
  return verdict;
}

}  // namespace sortie::tests
