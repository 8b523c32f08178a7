// SPDX-License-Identifier: BSD-3-Clause
// A voxel grid in fixed memory that rolls with the robot: blocks of 4 x 4 x 4 cells in a window that wraps
// around.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/block.hpp"
#include "mapping/grid/block_window.hpp"
#include "mapping/grid/rolling_grid_config.hpp"
#include "rt/archive.hpp"
#include "rt/samples.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::mapping {

/// What one scan did.
struct RollingInsert {
  Status status{Status::ok};  ///< `full` when a point was refused for want of room; or why none was taken
  RollingGridCounts points;   ///< of this scan only
};

/// Fixed-memory voxel grid. Points go in, active voxels come out; blocks beyond the local map go back to the
/// pool. What a scan does to the map does not depend on the order of its points, as long as the pools
/// suffice. Everything is stored relative to cells and blocks, so that it is as exact 10 km out as at the
/// origin, and the grid as a whole may be moved in the world at no cost. Cost: one look-up a point, no
/// probing; no heap.
class RollingGrid {
 public:
  /// Entries of the window that a configuration needs; 0 where it is not usable.
  static std::uint32_t window_entries(const RollingGridConfig& config);
  /// ok, or out_of_range: a setting outside its range.
  static Status check(const RollingGridConfig& config);

  /// Takes nothing (status out_of_range) when a setting or the memory is not usable.
  RollingGrid(const RollingGridConfig& config, const RollingGridMemory& memory);

  /// Adds the points of a scan taken at `pose` (world from sensor). First evicts what lies beyond the local
  /// map or was forgotten, then inserts. `hook` sees each block before it goes.
  RollingInsert insert(const rt::PointScan& scan, const RigidPose& pose, rt::Tick tick,
                       const EvictionHook& hook);

  /// Other ranges from the next scan on; what is in the map stays. `out_of_range` and no change unless
  /// 0 <= min < max, both finite.
  Status set_ranges(double min_m, double max_m);

  /// Blocks that the newest scan changed, in no order, and what changed in them.
  std::span<const BlockChange> changes() const { return memory_.changes.first(changed_); }

  /// Moves the whole map in the world, as a loop closure does: T_world_grid = correction * T_world_grid.
  /// O(1). Status: ok; not_finite; out_of_range (no rotation).
  Status move_grid(const RigidPose& correction);
  const RigidPose& world_from_grid() const { return world_grid_; }

  /// Block of the newest scan's sensor: the middle of the local map.
  const BlockAt& centre() const { return centre_; }
  const RollingGridOutput& output() const { return output_; }
  const RollingGridConfig& config() const { return config_; }

  /// Blocks are numbered 0 .. block_numbers() - 1; some of them are free.
  std::uint32_t block_numbers() const { return block_numbers_; }
  const Block& block(BlockIndex index) const { return memory_.blocks[index]; }
  std::span<const Block> blocks() const { return memory_.blocks; }
  /// Block at a place, or kNoBlock.
  BlockIndex find(const BlockAt& at) const {
    const BlockIndex index = window_[window_.entry(at)];
    return index != kNoBlock && memory_.blocks[index].key == at.key() ? index : kNoBlock;
  }
  /// The 27 blocks around one, in the order of directions, kNoBlock where there is none.
  void around(const Block& block, BlockIndex (&found)[kDirections]) const {
    std::uint32_t entries[kDirections];
    window_.around(BlockAt::from_key(block.key), entries);
    for (int d = 0; d < kDirections; ++d) {
      const BlockIndex index = window_[entries[d]];
      found[d] =
          index != kNoBlock && memory_.blocks[index].key == block.key + kKeySteps.step[d] ? index : kNoBlock;
    }
  }
  /// The same in two steps, with something else to do while memory answers: first what may be at a place,
  /// then what is.
  BlockIndex may_be(const BlockAt& at) const {
    const BlockIndex index = window_[window_.entry(at)];
    if (index != kNoBlock) __builtin_prefetch(&memory_.blocks[index]);
    return index;
  }
  bool is_next(const Block& block, int direction, BlockIndex other) const {
    return memory_.blocks[other].key == block.key + kKeySteps.step[direction];
  }
  /// Fetches what may_be() and a look at the voxels of a block will read.
  void prefetch_around(const Block& block) const {
    std::uint32_t entries[kDirections];
    window_.around(BlockAt::from_key(block.key), entries);
    for (int d = 9; d < 18; ++d) window_.prefetch(entries[d]);  // a column along z lies together
    prefetch_voxels(block);
  }
  /// Fetches the voxels of a block.
  void prefetch_voxels(const Block& block) const {
    const unsigned chunks = (bits_in(block.occupied) + Block::kChunk - 1) / Block::kChunk;
    for (unsigned i = 0; i < chunks; ++i)
      __builtin_prefetch(&memory_.voxels[std::size_t{block.chunks[i]} * Block::kChunk]);
  }
  /// Fetches the sums of some of a block's voxels.
  void prefetch_sums(const Block& block, std::uint64_t cells) const {
    if (!holds_normals()) return;
    for (std::uint64_t rest = cells & block.occupied; rest != 0; rest = without_lowest(rest)) {
      const NormalSums& record = sums(block, lowest(rest));
      __builtin_prefetch(&record);
      __builtin_prefetch(&record.count);
    }
  }
  /// Fetches the normals of a block's voxels.
  void prefetch_normals(const Block& block) const {
    if (!holds_normals()) return;
    const unsigned chunks = (bits_in(block.occupied) + Block::kChunk - 1) / Block::kChunk;
    for (unsigned i = 0; i < chunks; ++i)
      __builtin_prefetch(&memory_.normals[std::size_t{block.chunks[i]} * Block::kChunk]);
  }
  const Centroid& voxel(const Block& block, unsigned cell) const {
    return memory_.voxels[block.slot(block.rank(cell))];
  }
  bool holds_normals() const { return !memory_.normals.empty(); }
  const SurfaceNormal& normal(const Block& block, unsigned cell) const {
    return memory_.normals[block.slot(block.rank(cell))];
  }
  NormalSums& sums(const Block& block, unsigned cell) { return memory_.sums[block.slot(block.rank(cell))]; }
  const NormalSums& sums(const Block& block, unsigned cell) const {
    return memory_.sums[block.slot(block.rank(cell))];
  }
  std::span<Centroid> voxels() const { return memory_.voxels; }
  std::span<SurfaceNormal> normals() { return memory_.normals; }
  std::span<const SurfaceNormal> normals() const { return memory_.normals; }
  std::span<NormalSums> sums() { return memory_.sums; }

  /// Mean of a voxel's points in the grid's frame, m; offsets were cut down to whole steps, so half a step is
  /// added.
  rt::Vector3 centroid_m(const Block& block, unsigned cell) const;
  /// A point of the grid's frame in the world.
  rt::Vector3 to_world(const rt::Vector3& p_grid_m) const {
    return rt::rotate(world_grid_.q, p_grid_m) + world_grid_.p;
  }

  /// The whole map to bytes and back, into a grid of the same configuration and capacity. Between scans only.
  void archive(rt::Archive& archive);

 private:
  struct Seen;
  RollingInsert refuse(const rt::PointScan& scan, Status why);
  void locate(const rt::PointScan& scan, const RigidPose& grid_sensor, RollingGridCounts& counts,
              const EvictionHook& hook);
  void evict_beyond(std::uint32_t tick, const EvictionHook& hook, RollingGridCounts& counts);
  void evict(BlockIndex index, const EvictionHook& hook, RollingGridCounts& counts);
  BlockIndex take_block(const BlockAt& at, const EvictionHook& hook, RollingGridCounts& counts);
  bool force_out(const BlockAt& at, const EvictionHook& hook, RollingGridCounts& counts);
  BlockIndex farthest(const BlockAt& at);
  bool take_chunks(Block& block, unsigned voxels);
  void give_chunks(Block& block, unsigned voxels);
  void merge(BlockChange& change, Seen& seen, std::uint32_t tick, const EvictionHook& hook,
             RollingGridCounts& counts);
  void make_room(Block& block, std::uint64_t fresh);
  std::int64_t squared_distance(const BlockAt& at) const;
  void restore(rt::Archive& archive);
  bool claim(std::uint16_t chunk);
  bool are_free_lists();

  RollingGridConfig config_;
  RollingGridMemory memory_;
  bool usable_{};
  BlockWindow window_;
  RigidPose world_grid_;
  BlockAt centre_;                       ///< block of the sensor
  BlockIndex first_free_{kNoBlock};      ///< list through Block::chunks[0]
  std::uint16_t first_chunk_{kNoChunk};  ///< list through the first voxel of a free chunk
  std::uint32_t block_numbers_{};
  std::uint32_t chunk_numbers_{};
  std::uint32_t chunks_{};
  std::uint32_t hand_{};         ///< where the next look for evictions begins
  std::uint32_t victim_hand_{};  ///< the same, for a full pool
  bool swept_{};                 ///< what lay beyond the local map about `swept_at_` is gone
  BlockAt swept_at_;
  std::uint32_t changed_{};
  RollingGridOutput output_;
};

}  // namespace sortie::mapping
