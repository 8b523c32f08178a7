// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/chosen_map.hpp"

#include <algorithm>

#include "mapping/grid/mix64.hpp"

namespace sortie::firmware {
namespace {

mapping::RollingGridMemory grid_memory(const ChosenMapConfig& c, rt::Arena& arena) {
  const bool normals = c.by == SegmentsBy::smoothness;
  return {arena.make_array<mapping::Block>("map blocks", c.blocks),
          arena.make_array<mapping::BlockIndex>("map window", mapping::RollingGrid::window_entries(c.grid)),
          arena.make_array<mapping::Centroid>("voxels", c.voxels),
          arena.make_array<mapping::SurfaceNormal>("normals", normals ? c.voxels : 0),
          arena.make_array<mapping::NormalSums>("sums for normals", normals ? c.voxels : 0),
          arena.make_array<mapping::ScanEntry>("map scan", c.scan_points),
          arena.make_array<mapping::BlockChange>("map changes", c.blocks)};
}

/// On the measured drives 1.2 fragments a block were the most.
std::uint32_t nodes_for(std::uint32_t blocks) { return std::min(blocks + blocks / 2, 65'534u); }

mapping::SegmenterMemory segmenter_memory(const ChosenMapConfig& c, rt::Arena& arena) {
  const std::uint32_t nodes = nodes_for(c.blocks);
  mapping::LabellingMemory labelling{
      arena.make_array<mapping::NodeWork>("fragment work", nodes),
      arena.make_array<mapping::SegmentComponent>("segment components", nodes),
      arena.make_array<std::uint16_t>("fresh components", nodes),
      arena.make_array<mapping::SegmentSlot>("segments", c.most_segments),
      arena.make_array<mapping::SegmentEvent>("segment events", std::size_t{4} * c.most_segments)};
  return {arena.make_array<mapping::FragmentNode>("fragments", nodes),
          arena.make_array<mapping::NodeIndex>("block fragments", c.blocks),
          arena.make_array<mapping::BlockIndex>("segmenter queue", c.blocks),
          arena.make_array<mapping::BlockWork>("segmenter work", c.blocks), labelling};
}

std::uint64_t pair(std::uint32_t high, std::uint32_t low) { return std::uint64_t{high} << 32 | low; }

std::uint64_t voxel_name(const mapping::Block& block, unsigned cell) {
  return mapping::mix64(block.key << 6 | cell);
}

}  // namespace

ChosenMap::ChosenMap(const ChosenMapConfig& config, rt::Arena& arena)
    : config_(config), grid_(config.grid, grid_memory(config, arena)) {
  const double edge_m = config.grid.voxel_size_m;
  fragment_capacity_ = config.by == SegmentsBy::off ? 0 : nodes_for(config.blocks);
  if (kHasSmooth && config.by == SegmentsBy::smoothness) {
    const mapping::NormalsMemory memory{
        arena.make_array<mapping::NormalWork>("normal work", config.blocks),
        arena.make_array<mapping::BlockIndex>("normal queue", std::size_t{2} * config.blocks)};
    normals_.emplace(config.normals, grid_, memory);
    smooth_.emplace(config.segments, edge_m,
                    mapping::SmoothnessPolicy(config.most_angle_rad, config.most_curvature),
                    segmenter_memory(config, arena));
  } else if (kHasEuclidean && config.by == SegmentsBy::euclidean) {
    euclidean_.emplace(config.segments, edge_m, mapping::EuclideanPolicy{}, segmenter_memory(config, arena));
  }
}

mapping::RollingInsert ChosenMap::insert(const rt::PointScan& scan, const mapping::RigidPose& pose,
                                         rt::Tick tick) {
  mapping::RollingInsert result;
  const bool segments = with_segmenter(*this, [&](auto& segmenter) {
    mapping::LocalMap map(grid_, normals_ ? &*normals_ : nullptr, segmenter);
    result = map.insert(scan, pose, tick);
    // A scan that was refused changes nothing, and leaves the changes of the one before where they are.
    if (result.points.used == 0 && result.points.evicted == 0) return;
    normals_backlog_ = map.update_normals().backlog;
    current_ = done_ = false;
  });
  if (!segments) result = grid_.insert(scan, pose, tick, {});
  if (result.points.used > 0 || result.points.evicted > 0) digest_changes();
  return result;
}

void ChosenMap::segment(rt::Tick tick) {
  const bool segments = with_segmenter(*this, [&](auto& segmenter) {
    const mapping::SegmenterStep step = segmenter.update(grid_, static_cast<std::uint32_t>(tick));
    backlog_ = step.backlog;
    current_ = step.current || segmenter.status() != Status::ok;
    done_ = step.done;
    digest_events();
  });
  if (!segments) current_ = done_ = true;
}

/// What the newest scan changed, in no order, goes onto the chain.
void ChosenMap::digest_changes() {
  std::uint64_t sum = 0;
  for (const mapping::BlockChange& change : grid_.changes()) {
    const mapping::Block& block = grid_.block(change.block);
    for (std::uint64_t cells = change.moved; cells != 0; cells = mapping::without_lowest(cells)) {
      const unsigned cell = mapping::lowest(cells);
      const mapping::Centroid& c = grid_.voxel(block, cell);
      const std::uint64_t held = pair(std::uint32_t{c.x} << 16 | c.y, std::uint32_t{c.z} << 16 | c.count);
      sum += mapping::mix64(voxel_name(block, cell) ^ held);
    }
  }
  if (kHasSmooth && normals_) {
    for (const mapping::BlockIndex index : normals_->turned_blocks()) {
      const mapping::Block& block = grid_.block(index);
      for (std::uint64_t cells = normals_->turned(index); cells != 0;
           cells = mapping::without_lowest(cells)) {
        const unsigned cell = mapping::lowest(cells);
        const mapping::SurfaceNormal& n = grid_.normal(block, cell);
        std::uint64_t held = n.curvature;
        for (const std::int16_t part : n.normal) held = held << 16 | static_cast<std::uint16_t>(part);
        sum += mapping::mix64(~voxel_name(block, cell) ^ held);
      }
    }
  }
  change_digest_ = mapping::mix64(change_digest_ + sum);
}

void ChosenMap::digest_events() {
  const mapping::Labelling& segments = *labelling();
  const std::uint64_t finished = segments.counts().labellings;
  if (finished == labellings_) return;
  if (finished > labellings_ + 1) events_unseen_ += finished - labellings_ - 1;
  labellings_ = finished;
  if (segments.events().empty()) return;
  std::uint64_t sum = 0;
  for (const mapping::SegmentEvent& event : segments.events())
    sum += mapping::mix64(pair(event.id, event.other) +
                          mapping::mix64(static_cast<std::uint64_t>(event.change)));
  change_digest_ = mapping::mix64(change_digest_ + sum);
}

const mapping::Labelling* ChosenMap::labelling() const {
  const mapping::Labelling* found = nullptr;
  with_segmenter(*this, [&found](const auto& segmenter) { found = &segmenter.labelling(); });
  return found;
}

const mapping::FragmentGraph* ChosenMap::graph() const {
  const mapping::FragmentGraph* found = nullptr;
  with_segmenter(*this, [&found](const auto& segmenter) { found = &segmenter.graph(); });
  return found;
}

SegmentSummary ChosenMap::summary() const {
  SegmentSummary summary;
  const mapping::Labelling* segments = labelling();
  if (segments == nullptr) return summary;
  for (const mapping::SegmentSlot& slot : segments->slots()) {
    const std::uint32_t voxels = slot.voxels[segments->shown()];
    if (slot.id == mapping::kNoSegment || voxels == 0) continue;
    ++summary.segments;
    summary.voxels += voxels;
    summary.largest = std::max(summary.largest, voxels);
    summary.digest += mapping::mix64(pair(slot.id, voxels));
  }
  summary.backlog = backlog_;
  summary.current = current_;
  summary.lives = segments->counts();
  return summary;
}

VoxelOnMap ChosenMap::voxel(mapping::BlockIndex index, unsigned cell) const {
  const mapping::Block& block = grid_.block(index);
  VoxelOnMap voxel;
  rt::store(grid_.to_world(grid_.centroid_m(block, cell)), voxel.p_world_m);
  voxel.count = grid_.voxel(block, cell).count;
  with_segmenter(*this,
                 [&](const auto& segmenter) { voxel.segment = segmenter.segment_of(grid_, index, cell); });
  if (kHasSmooth && normals_) {
    const mapping::SurfaceNormal& n = grid_.normal(block, cell);
    const rt::Vector3 normal{n.normal[0] / 32767.0, n.normal[1] / 32767.0, n.normal[2] / 32767.0};
    rt::store(rt::rotate(grid_.world_from_grid().q, normal), voxel.normal_world);
  }
  return voxel;
}

void ChosenMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "map")
      .fixed(config_, normals_, fragment_capacity_)
      .by_hand(grid_, euclidean_, smooth_)
      .scratch(labellings_)
      .state(current_, done_, backlog_, normals_backlog_, events_unseen_, change_digest_);
  grid_.archive(archive);
  with_segmenter(*this, [&](auto& segmenter) { segmenter.archive(archive, grid_); });
  if (const mapping::Labelling* segments = labelling(); segments != nullptr && archive.is_reading())
    labellings_ = segments->counts().labellings;
}

}  // namespace sortie::firmware
