// SPDX-License-Identifier: BSD-3-Clause
// The rolling grid's pools: which blocks there are, which go.
#include "mapping/grid/rolling_grid.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kMostBlocks = 65534;
constexpr std::uint32_t kMostVoxels = 65534 * Block::kChunk;
constexpr std::int32_t kEvictionWindow = 16;
constexpr std::int32_t kHysteresis = 4;  ///< cells that a block may lie outside before it goes

bool in(double value, double low, double high) { return value >= low && value <= high; }

/// Bits of a window that is a power of two and holds a local map with room for blocks on its rim.
unsigned bits_for(double half_cells) {
  const double blocks = std::ceil(half_cells / 4.0) * 2.0 + 6.0;
  unsigned bits = 2;
  while ((1 << bits) < blocks && bits < 16) ++bits;
  return bits;
}
unsigned bits_xy(const RollingGridConfig& c) { return bits_for(c.radius_m / c.voxel_size_m); }
unsigned bits_z(const RollingGridConfig& c) { return bits_for(c.half_height_m / c.voxel_size_m); }
}  // namespace

Status RollingGrid::check(const RollingGridConfig& c) {
  const bool sizes = in(c.voxel_size_m, 0.01, 10) && in(c.min_range_m, 0, 1e6) && in(c.max_range_m, 0, 1e6) &&
                     c.min_range_m < c.max_range_m && c.radius_m >= 4 * c.voxel_size_m &&
                     c.half_height_m >= 4 * c.voxel_size_m && c.radius_m <= 1000 * c.voxel_size_m &&
                     c.half_height_m <= 1000 * c.voxel_size_m;
  const bool numbers =
      c.min_points >= 1 && c.min_points <= 255 && c.mean_window >= 1 && c.mean_window <= 65535;
  return sizes && numbers ? Status::ok : Status::out_of_range;
}

Status RollingGrid::set_ranges(double min_m, double max_m) {
  RollingGridConfig changed = config_;
  changed.min_range_m = min_m;
  changed.max_range_m = max_m;
  if (check(changed) != Status::ok) return Status::out_of_range;
  config_ = changed;
  return Status::ok;
}

std::uint32_t RollingGrid::window_entries(const RollingGridConfig& config) {
  return check(config) == Status::ok ? BlockWindow::entries_for(bits_xy(config), bits_z(config)) : 0;
}

RollingGrid::RollingGrid(const RollingGridConfig& config, const RollingGridMemory& memory)
    : config_(config),
      memory_(memory),
      usable_(check(config) == Status::ok && !memory.blocks.empty() && memory.blocks.size() <= kMostBlocks &&
              memory.voxels.size() >= Block::kChunk && memory.voxels.size() <= kMostVoxels &&
              (memory.normals.empty() || memory.normals.size() == memory.voxels.size()) &&
              memory.sums.size() == memory.normals.size() && memory.window.size() >= window_entries(config) &&
              !memory.scan.empty() && memory.changes.size() >= memory.blocks.size()),
      window_(usable_ ? memory.window : std::span<BlockIndex>{}, usable_ ? bits_xy(config) : 1,
              usable_ ? bits_z(config) : 1) {
  for (Block& block : memory_.blocks) block.key = Block::kFree;
}

Status RollingGrid::move_grid(const RigidPose& correction) {
  if (!rt::is_finite(correction.p) || !rt::is_finite(correction.q)) return Status::not_finite;
  if (std::fabs(squared_norm(correction.q) - 1.0) > 1e-3) return Status::out_of_range;
  const rt::Quaternion q = normalised(correction.q);
  world_grid_ = {rt::rotate(q, world_grid_.p) + correction.p, normalised(q * world_grid_.q)};
  return Status::ok;
}

rt::Vector3 RollingGrid::centroid_m(const Block& block, unsigned cell) const {
  const BlockAt at = BlockAt::from_key(block.key);
  const Centroid& c = voxel(block, cell);
  const auto coordinate = [this](std::int32_t block_at, unsigned cell_at, std::uint16_t offset) {
    return config_.voxel_size_m *
           (4.0 * block_at + static_cast<double>(cell_at) + (static_cast<double>(offset) + 0.5) / 65536.0);
  };
  return {coordinate(at.x, cell & 3, c.x), coordinate(at.y, (cell >> 2) & 3, c.y),
          coordinate(at.z, cell >> 4, c.z)};
}

/// From the block of the sensor, in blocks, horizontally.
std::int64_t RollingGrid::squared_distance(const BlockAt& at) const {
  const std::int64_t dx = at.x - centre_.x;
  const std::int64_t dy = at.y - centre_.y;
  return dx * dx + dy * dy;
}

void RollingGrid::evict_beyond(std::uint32_t tick, const EvictionHook& hook, RollingGridCounts& counts) {
  // What was taken since then lay within the radius, give or take a block: it may stay as long as the sensor.
  const bool stays = swept_at_.key() == centre_.key();
  if (swept_ && stays && config_.forget_ticks == 0) return;
  const double reach = config_.radius_m / config_.voxel_size_m + kHysteresis;
  const auto most2 = static_cast<std::int64_t>(reach * reach / 16.0) + 1;
  const auto most_z =
      static_cast<std::int32_t>((config_.half_height_m / config_.voxel_size_m + kHysteresis) / 4.0) + 1;
  const std::uint32_t most = config_.evict_blocks > 0 ? config_.evict_blocks : kMostBlocks;
  std::uint32_t marked = 0;
  if (hand_ >= block_numbers_) hand_ = 0;
  const std::uint32_t first = hand_;
  for (std::uint32_t i = 0; i < block_numbers_ && marked < most; ++i) {
    const std::uint32_t index = first + i < block_numbers_ ? first + i : first + i - block_numbers_;
    Block& block = memory_.blocks[index];
    if (!block.in_use()) continue;
    const BlockAt at = BlockAt::from_key(block.key);
    const bool forgotten = config_.forget_ticks > 0 && tick - block.last_tick > config_.forget_ticks;
    if (!forgotten && squared_distance(at) <= most2 && std::abs(at.z - centre_.z) <= most_z) continue;
    block.leaving = 1;
    hand_ = index + 1;
    // The scratch list of the scan is free until the points come.
    memory_.changes[marked++].block = static_cast<BlockIndex>(index);
  }
  swept_ = marked < most;
  swept_at_ = centre_;
  for (std::uint32_t i = 0; i < marked; ++i) evict(memory_.changes[i].block, hook, counts);
}

void RollingGrid::evict(BlockIndex index, const EvictionHook& hook, RollingGridCounts& counts) {
  Block& block = memory_.blocks[index];
  block.leaving = 1;
  if (hook.call != nullptr) hook.call(hook.context, index);
  const unsigned voxels = bits_in(block.occupied);
  counts.evicted += voxels;
  output_.voxels -= voxels;
  --output_.blocks;
  BlockIndex& entry = window_[window_.entry(BlockAt::from_key(block.key))];
  if (entry == index) entry = kNoBlock;
  give_chunks(block, voxels);
  block = Block{};
  block.key = Block::kFree;
  block.chunks[0] = first_free_;
  first_free_ = index;
}

/// A block for a place that has none; kNoBlock when none can be had.
BlockIndex RollingGrid::take_block(const BlockAt& at, const EvictionHook& hook, RollingGridCounts& counts) {
  BlockIndex& entry = window_[window_.entry(at)];
  if (entry != kNoBlock) {  // A block a whole window away that the budget of evictions left there.
    if (memory_.blocks[entry].touch != Block::kUntouched) return kNoBlock;
    ++counts.forced;
    evict(entry, hook, counts);
  }
  if (first_free_ == kNoBlock && block_numbers_ == memory_.blocks.size()) {
    if (!force_out(at, hook, counts)) return kNoBlock;
  }
  BlockIndex index = first_free_;
  if (index != kNoBlock) {
    first_free_ = memory_.blocks[index].chunks[0];
  } else {
    index = static_cast<BlockIndex>(block_numbers_++);
  }
  memory_.blocks[index] = Block{};
  memory_.blocks[index].key = at.key();
  entry = index;
  output_.most_blocks = std::max(output_.most_blocks, ++output_.blocks);
  return index;
}

/// Lets a far block give way to one that is nearer. False when none does.
bool RollingGrid::force_out(const BlockAt& at, const EvictionHook& hook, RollingGridCounts& counts) {
  const BlockIndex victim = config_.evict_farthest ? farthest(at) : kNoBlock;
  if (victim == kNoBlock) return false;
  ++counts.forced;
  evict(victim, hook, counts);
  return true;
}

/// Of the next blocks in the pool the one farthest from the sensor, if it is farther than a new one and not
/// part of the present scan.
BlockIndex RollingGrid::farthest(const BlockAt& at) {
  BlockIndex victim = kNoBlock;
  std::int64_t most = squared_distance(at);
  for (std::int32_t i = 0; i < kEvictionWindow; ++i) {
    if (victim_hand_ >= block_numbers_) victim_hand_ = 0;
    const std::uint32_t index = victim_hand_++;
    const Block& block = memory_.blocks[index];
    if (!block.in_use() || block.touch != Block::kUntouched) continue;
    const std::int64_t distance = squared_distance(BlockAt::from_key(block.key));
    if (distance <= most) continue;
    most = distance;
    victim = static_cast<BlockIndex>(index);
  }
  return victim;
}

/// Room for `voxels` voxels in a block. False, and nothing changed, when the pool cannot give it.
bool RollingGrid::take_chunks(Block& block, unsigned voxels) {
  const unsigned held = (bits_in(block.occupied) + Block::kChunk - 1) / Block::kChunk;
  const unsigned wanted = (voxels + Block::kChunk - 1) / Block::kChunk;
  if (wanted <= held) return true;
  if (memory_.voxels.size() / Block::kChunk - chunks_ < wanted - held) return false;
  for (unsigned i = held; i < wanted; ++i) {
    std::uint16_t chunk = first_chunk_;
    if (chunk != kNoChunk) {
      first_chunk_ = memory_.voxels[std::size_t{chunk} * Block::kChunk].x;
    } else {
      chunk = static_cast<std::uint16_t>(chunk_numbers_++);
    }
    block.chunks[i] = chunk;
  }
  chunks_ += wanted - held;
  output_.most_chunks = std::max(output_.most_chunks, chunks_);
  return true;
}

void RollingGrid::give_chunks(Block& block, unsigned voxels) {
  const unsigned held = (voxels + Block::kChunk - 1) / Block::kChunk;
  for (unsigned i = 0; i < held; ++i) {
    memory_.voxels[std::size_t{block.chunks[i]} * Block::kChunk].x = first_chunk_;
    first_chunk_ = block.chunks[i];
  }
  chunks_ -= held;
}

}  // namespace sortie::mapping
