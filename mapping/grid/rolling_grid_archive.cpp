// SPDX-License-Identifier: BSD-3-Clause
// The rolling grid's state to bytes and back: its pools as they are, up to their high water.

#include "mapping/grid/rolling_grid.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kMapFormat = 4;
}  // namespace

void RollingGrid::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "rolling grid")
      .fixed(config_, memory_, usable_)
      .by_hand(window_, first_chunk_, first_free_, block_numbers_, chunk_numbers_, chunks_, hand_,
               victim_hand_)
      .scratch(changed_)
      .state(world_grid_, centre_, output_, swept_, swept_at_);
  archive.expect(kMapFormat, "the map has another format version");
  if (!usable_) return;
  const bool reading = archive.is_reading();
  archive.expect(memory_.blocks.size(), "the map has another number of blocks");
  archive.expect(memory_.voxels.size(), "the map has another number of voxels");
  archive.expect(memory_.normals.size(), "the map has another number of normals");
  archive.bounded(block_numbers_, memory_.blocks.size());
  archive.bounded(chunk_numbers_, memory_.voxels.size() / Block::kChunk);
  archive.bounded(hand_, memory_.blocks.size());
  archive.bounded(victim_hand_, memory_.blocks.size());
  for (Block& block : memory_.blocks.first(block_numbers_)) {
    archive.value(block.key);
    archive.value(block.occupied);
    archive.value(block.active);
    archive.value(block.last_tick);
    archive.value(block.chunks);
  }
  for (std::uint32_t i = 0; i < chunk_numbers_ * Block::kChunk; ++i) {
    archive.value(memory_.voxels[i]);
    if (!holds_normals()) continue;
    archive.value(memory_.normals[i]);
    archive.value(memory_.sums[i]);
  }
  // Which free block or chunk is taken next decides what a full pool lets go: the lists keep their order.
  archive.value(first_free_);
  archive.value(first_chunk_);
  if (!reading) return;
  restore(archive);
}

/// Builds what follows from the blocks: the window and the counts. Bytes that make no map leave an empty one.
void RollingGrid::restore(rt::Archive& archive) {
  window_.clear();
  changed_ = 0;
  chunks_ = 0;
  output_.voxels = output_.blocks = 0;
  // The scratch of scans marks chunks that are in use; one that is used twice makes no map.
  bool good = archive.status() == Status::ok;
  for (BlockChange& change : memory_.changes) change.moved = 0;
  for (std::uint32_t i = 0; i < block_numbers_ && good; ++i) {
    Block& block = memory_.blocks[i];
    block.touch = Block::kUntouched;
    block.leaving = 0;
    if (!block.in_use()) continue;
    BlockIndex& entry = window_[window_.entry(BlockAt::from_key(block.key))];
    const unsigned voxels = bits_in(block.occupied);
    const unsigned chunks = (voxels + Block::kChunk - 1) / Block::kChunk;
    good = entry == kNoBlock && voxels > 0 && (block.active & ~block.occupied) == 0 &&
           block.key >> (3 * BlockAt::kBits) == 0;
    for (unsigned k = 0; k < chunks && good; ++k)
      good = block.chunks[k] < chunk_numbers_ && claim(block.chunks[k]);
    entry = static_cast<BlockIndex>(i);
    chunks_ += chunks;
    output_.voxels += voxels;
    ++output_.blocks;
  }
  if (!good || !are_free_lists()) {
    archive.fail(Status::malformed, "blocks that cannot lie in one grid");
    window_.clear();
    for (Block& block : memory_.blocks) block.key = Block::kFree;
    first_free_ = kNoBlock;
    first_chunk_ = kNoChunk;
    block_numbers_ = chunk_numbers_ = chunks_ = 0;
    output_.voxels = output_.blocks = 0;
    return;
  }
  for (std::uint32_t i = block_numbers_; i < memory_.blocks.size(); ++i) memory_.blocks[i].key = Block::kFree;
}

/// Whether the lists hold every free block and every free chunk once, and no other.
bool RollingGrid::are_free_lists() {
  std::uint32_t found = output_.blocks;
  for (BlockIndex index = first_free_; index != kNoBlock; index = memory_.blocks[index].chunks[0]) {
    if (index >= block_numbers_ || memory_.blocks[index].in_use() || ++found > block_numbers_) return false;
  }
  if (found != block_numbers_) return false;
  found = chunks_;
  for (std::uint16_t chunk = first_chunk_; chunk != kNoChunk;
       chunk = memory_.voxels[std::size_t{chunk} * Block::kChunk].x) {
    if (chunk >= chunk_numbers_ || !claim(chunk) || ++found > chunk_numbers_) return false;
  }
  return found == chunk_numbers_;
}

/// Marks a chunk as used, one bit each; false when it was. Blocks of the scratch hold 64 of them: there are
/// at most as many chunks as 16 a block.
bool RollingGrid::claim(std::uint16_t chunk) {
  const std::size_t at = chunk / 64u;
  if (at >= memory_.changes.size()) return false;
  const std::uint64_t bit = cell_bit(chunk % 64u);
  if ((memory_.changes[at].moved & bit) != 0) return false;
  memory_.changes[at].moved |= bit;
  return true;
}

}  // namespace sortie::mapping
