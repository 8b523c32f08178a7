// SPDX-License-Identifier: BSD-3-Clause
// Settings, memory and results of the rolling grid.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/block.hpp"
#include "mapping/grid/normal_record.hpp"
#include "rt/describe.hpp"
#include "rt/keys.hpp"
#include "rt/rotation.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Settings of the rolling grid. The defaults work in a building and around one.
struct RollingGridConfig {
  double voxel_size_m{0.1};          ///< [0.01, 10]
  double min_range_m{0.5};           ///< nearer points (the robot itself, missing returns at 0) are refused
  double max_range_m{60.0};          ///< farther points are refused
  double radius_m{20.0};             ///< of the local map about the sensor, horizontally; at least 4 voxels
  double half_height_m{5.5};         ///< of the local map, above and below the sensor; at least 4 voxels
  std::uint32_t min_points{1};       ///< from which a voxel is active: [1, 255]
  std::uint32_t mean_window{65535};  ///< points a mean remembers, [1, 65535]: a small one follows what moved
  std::uint32_t forget_ticks{0};     ///< a block without a new point for longer is evicted; 0: never
  std::uint32_t evict_blocks{0};     ///< most blocks evicted a scan by distance and age; 0: no limit
  bool evict_farthest{true};         ///< full pool: a far, old block gives way; else the new point is refused

  /// The ticks are milliseconds.
  SORTIE_KEYS(c, key) {
    key("voxel_m", c.voxel_size_m, {0.01, 10, "m", "edge of a voxel", rt::kKnob});
    key("min_range_m", c.min_range_m, {0, 100, "m", "nearer returns are refused"},
        [](auto& map, double value) { return map.set_ranges(value, map.config().max_range_m); });
    key("max_range_m", c.max_range_m, {0.1, 1000, "m", "farther returns are refused", rt::kKnob},
        [](auto& map, double value) { return map.set_ranges(map.config().min_range_m, value); });
    key("radius_m", c.radius_m,
        {0.04, 1e4, "m", "of the local map about the sensor, horizontally", rt::kKnob});
    key("half_height_m", c.half_height_m, {0.04, 1e4, "m", "of the local map, above and below the sensor"});
    key("min_points", c.min_points, {1, 255, "points", "from which a voxel is part of the map", rt::kKnob});
    key("mean_window", c.mean_window,
        {1, 65535, "points", "that a voxel's mean remembers: a small number follows what moved", rt::kKnob});
    key("evict_blocks", c.evict_blocks,
        {0, 65534, "blocks", "most that a scan may evict by distance or age; 0: no limit", rt::kKnob});
    key("forget_s", c.forget_ticks,
        {0, 1e6, {"s", 1e3}, "blocks without a new return for longer go; 0: never", rt::kKnob});
    key("when_full", c.evict_farthest,
        {"what happens to points of new voxels when a pool is full",
         {{"refuse", false}, {"evict_farthest", true}}});
  }
};

/// Memory of a grid, which outlives it: value-initialised arrays.
struct RollingGridMemory {
  std::span<Block> blocks;                ///< at most 65,534
  std::span<BlockIndex> window;           ///< RollingGrid::window_entries(config)
  std::span<Centroid> voxels;             ///< a multiple of 4, at most 262,136
  std::span<SurfaceNormal> normals;       ///< as long as `voxels`, or empty: no normals
  std::span<NormalSums> sums;             ///< as long as `normals`
  std::span<struct ScanEntry> scan;       ///< most points of one scan
  std::span<struct BlockChange> changes;  ///< as long as `blocks`
};

/// Scratch: a point on its way into its block. 12 bytes.
struct ScanEntry {
  std::uint32_t next{};
  std::uint16_t offset[3]{};
  std::uint16_t cell{};
};

/// What a scan changed in one block.
struct BlockChange {
  std::uint64_t moved{};      ///< active voxels whose mean is another one now, the activated ones among them
  std::uint64_t activated{};  ///< voxels that became active
  std::uint32_t first{};      ///< scratch: of the points that fell into it
  BlockIndex block{};
  std::uint16_t drift{};  ///< two voxels that were active before came apart by less, in kDriftStep
};
/// Of 1/65536 of a cell.
inline constexpr std::uint32_t kDriftStep = 16;
inline constexpr std::uint16_t kAnyDrift = 0xffff;

/// What became of points, whoever looked at them. in = used + all others, with the points of what derives
/// from it.
struct PointCounts {
  std::uint64_t in{};
  std::uint64_t used{};
  std::uint64_t not_finite{};
  std::uint64_t too_near{};
  std::uint64_t too_far{};
  std::uint64_t scan_full{};  ///< beyond the longest scan that the memory is for
  SORTIE_FIELDS(in, used, not_finite, too_near, too_far, scan_full)
};

/// Points that only the grid refuses.
struct GridRefusals {
  std::uint64_t outside{};      ///< not in the local map
  std::uint64_t out_of_grid{};  ///< all points of scans taken farther from the origin than the grid reaches
  std::uint64_t pool_full{};
  std::uint64_t bad_pose{};  ///< all points of scans whose pose was not finite or no rotation
  SORTIE_FIELDS(outside, out_of_grid, pool_full, bad_pose)
};

/// What became of the points that the grid was given; the last three count voxels and blocks.
struct RollingGridCounts : PointCounts, GridRefusals {
  std::uint64_t created{};  ///< voxels
  std::uint64_t evicted{};  ///< voxels
  std::uint64_t forced{};   ///< blocks that gave way to a point, not to distance or age
  SORTIE_FIELDS(in, used, not_finite, too_near, too_far, outside, out_of_grid, pool_full, scan_full, bad_pose,
                created, evicted, forced)
};

/// State of the grid as a task shows it.
struct RollingGridOutput {
  std::uint64_t scans{};
  RollingGridCounts points;
  std::uint32_t voxels{};
  std::uint32_t blocks{};
  std::uint32_t most_voxels{};  ///< high water
  std::uint32_t most_blocks{};
  std::uint32_t most_chunks{};
  SORTIE_FIELDS(scans, points, voxels, blocks, most_voxels, most_blocks, most_chunks)
};

/// Where the grid lies in the world, or a sensor in it: x_a = q * x_b + p.
struct RigidPose {
  rt::Vector3 p;
  rt::Quaternion q;
  SORTIE_FIELDS(p, q)
};

/// Called with each block before it is given back, while its voxels are still there.
struct EvictionHook {
  void (*call)(void* context, BlockIndex block){};
  void* context{};
};

}  // namespace sortie::mapping
