// SPDX-License-Identifier: BSD-3-Clause
// A rolling grid and a segmenter with memory of their own, for tests and benchmarks.
#pragma once

#include <type_traits>
#include <vector>

#include "mapping/grid/rolling_grid.hpp"
#include "mapping/segments/local_map.hpp"
#include "mapping/segments/segmenter.hpp"

namespace sortie::tests {

/// Sizes of the pools.
struct MapSizes {
  std::uint32_t blocks{512};
  std::uint32_t voxels{8192};
  std::uint32_t nodes{2048};
  std::uint32_t points{4096};
  std::uint32_t slots{2048};
  std::uint32_t events{4096};
};

/// A grid with memory of its own.
struct OwnedRollingGrid {
  std::vector<mapping::Block> blocks;
  std::vector<mapping::BlockIndex> window;
  std::vector<mapping::Centroid> voxels;
  std::vector<mapping::SurfaceNormal> normals;
  std::vector<mapping::NormalSums> sums;
  std::vector<mapping::ScanEntry> scan;
  std::vector<mapping::BlockChange> changes;
  mapping::RollingGrid grid;

  OwnedRollingGrid(const mapping::RollingGridConfig& config, const MapSizes& sizes, bool with_normals = false)
      : blocks(sizes.blocks),
        window(mapping::RollingGrid::window_entries(config)),
        voxels(sizes.voxels),
        normals(with_normals ? sizes.voxels : 0),
        sums(with_normals ? sizes.voxels : 0),
        scan(sizes.points),
        changes(sizes.blocks),
        grid(config, {blocks, window, voxels, normals, sums, scan, changes}) {}
  OwnedRollingGrid(const OwnedRollingGrid&) = delete;
  OwnedRollingGrid& operator=(const OwnedRollingGrid&) = delete;
};

/// A segmenter with memory of its own.
template <class Policy>
struct OwnedSegmenter {
  std::vector<mapping::FragmentNode> nodes;
  std::vector<mapping::NodeIndex> first;
  std::vector<mapping::BlockIndex> queue;
  std::vector<mapping::BlockWork> block_work;
  std::vector<mapping::NodeWork> work;
  std::vector<mapping::SegmentComponent> components;
  std::vector<std::uint16_t> fresh;
  std::vector<mapping::SegmentSlot> slots;
  std::vector<mapping::SegmentEvent> events;
  mapping::Segmenter<Policy> segmenter;

  OwnedSegmenter(const mapping::SegmenterConfig& config, double voxel_size_m, const MapSizes& sizes,
                 const Policy& policy = {})
      : nodes(sizes.nodes),
        first(sizes.blocks),
        queue(sizes.blocks),
        block_work(sizes.blocks),
        work(sizes.nodes),
        components(sizes.nodes),
        fresh(sizes.nodes),
        slots(sizes.slots),
        events(sizes.events),
        segmenter(config, voxel_size_m, policy,
                  {nodes, first, queue, block_work, {work, components, fresh, slots, events}}) {}
  OwnedSegmenter(const OwnedSegmenter&) = delete;
  OwnedSegmenter& operator=(const OwnedSegmenter&) = delete;
};

/// Grid, segmenter and, where the policy needs them, normals, wired.
template <class Policy>
struct OwnedMap {
  static constexpr bool kNormals = !std::is_same_v<Policy, mapping::EuclideanPolicy>;
  OwnedRollingGrid owned;
  std::vector<mapping::NormalWork> normal_work;
  std::vector<mapping::BlockIndex> normal_queue;
  mapping::Normals normals;
  OwnedSegmenter<Policy> segments;
  mapping::LocalMap<Policy> map;

  OwnedMap(const mapping::RollingGridConfig& grid_config, const mapping::SegmenterConfig& config,
           const MapSizes& sizes, const Policy& policy = Policy{}, const mapping::NormalsConfig& normal = {})
      : owned(grid_config, sizes, kNormals),
        normal_work(kNormals ? sizes.blocks : 0),
        normal_queue(kNormals ? 2 * sizes.blocks : 0),
        normals(normal, owned.grid, {normal_work, normal_queue}),
        segments(config, grid_config.voxel_size_m, sizes, policy),
        map(owned.grid, kNormals ? &normals : nullptr, segments.segmenter) {}

  const mapping::RollingGrid& grid() const { return owned.grid; }
  const mapping::Segmenter<Policy>& segmenter() const { return segments.segmenter; }
};
using EuclideanMap = OwnedMap<mapping::EuclideanPolicy>;
using SmoothMap = OwnedMap<mapping::SmoothnessPolicy>;

}  // namespace sortie::tests
