// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's work on one block: its fragments, and which fragments around they touch. Included by
// mapping/segmenter.hpp only.
#pragma once

#include "mapping/segmenter.hpp"

namespace sortie::mapping {

/// The block that is looked at: its voxels laid out by cell, and the fragments they make.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Here {
  std::uint64_t cores{};
  unsigned parts{};
  std::array<UnitPoint, Block::kCells> at;
  std::array<typename Policy::Voxel, Block::kCells> voxel;
  std::array<std::uint64_t, Block::kCells> part;
};

template <SegmentationPolicy Policy>
SegmenterStep Segmenter<Policy>::update(const RollingGrid& grid, std::uint32_t tick) {
  SegmenterStep step;
  const std::uint32_t most = config_.units > 0 ? config_.units : 0xffffffffu - kBlockUnits;
  while (status_ == Status::ok && step.units < most) {
    if (labelling_.running()) {
      step.units += labelling_.run(graph_, grid.blocks(), most - step.units);
      if (!labelling_.running()) graph_.hold(false);
    } else if (left_of_cycle_ > 0) {
      --left_of_cycle_;
      --queue_size_;
      const BlockIndex block = queue_[queue_first_];
      queue_first_ = queue_first_ + 1 < queue_.size() ? queue_first_ + 1 : 0;
      queued_[block] = 0;
      if (!grid.block(block).in_use()) continue;
      look_at(grid, block);
      ++step.blocks;
      step.units += kBlockUnits;
    } else if (changed_) {
      changed_ = false;
      labelling_.start(tick);
      graph_.hold(true);
    } else if (queue_size_ > 0) {
      ++cycle_;
      left_of_cycle_ = queue_size_;
      changed_ = true;
    } else {
      break;
    }
  }
  step.backlog = queue_size_;
  step.current = status_ == Status::ok && queue_size_ == 0 && !changed_ && !labelling_.running();
  return step;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::forget(const RollingGrid& grid, BlockIndex block) {
  if (status_ != Status::ok || graph_.first(block) == kNoNode) return;
  const BlockAt at = BlockAt::from_key(grid.block(block).key);
  for (int direction = 0; direction < kHere; ++direction) {
    const BlockIndex other = grid.find(at.next(direction));
    if (other != kNoBlock) graph_.disconnect(other, 26 - direction);
  }
  graph_.give(block);
  changed_ = true;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::look_at(const RollingGrid& grid, BlockIndex block) {
  Here here;
  fragment(grid, block, here);
  std::uint64_t before = 0;
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next)
    before |= graph_[node].cells;
  graph_.drop_forward(block);
  renew_nodes(block, here);
  const BlockAt at = BlockAt::from_key(grid.block(block).key);
  for (int direction = 0; direction < kDirections; ++direction) {
    if (direction == kHere || ((before | here.cores) & reach_.rim(direction)) == 0) continue;
    const BlockIndex other = grid.find(at.next(direction));
    if (other == kNoBlock || graph_.first(other) == kNoNode) continue;
    if (direction < kHere) graph_.disconnect(other, 26 - direction);
    // One that is still to be looked at before the labelling tests the pair itself.
    if (queued_[other] != tag(cycle_)) connect(grid, block, here, other, direction);
  }
}

/// Connected parts of the block by themselves, in the order of their first cells.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::fragment(const RollingGrid& grid, BlockIndex index, Here& here) {
  const Block& block = grid.block(index);
  unsigned rank = 0;
  for (std::uint64_t rest = block.occupied; rest != 0; rest = without_lowest(rest), ++rank) {
    const unsigned cell = lowest(rest);
    if ((block.active & cell_bit(cell)) == 0) continue;
    const std::uint32_t slot = block.slot(rank);
    here.at[cell] = unit_point(grid.voxels()[slot], cell);
    here.voxel[cell] = policy_.load(grid, slot);
    if (policy_.core(here.voxel[cell])) here.cores |= cell_bit(cell);
  }
  std::uint64_t left = here.cores;
  while (left != 0) {
    std::uint64_t part = left & (~left + 1);
    std::uint64_t todo = part;
    left ^= part;
    while (todo != 0 && left != 0) {
      const unsigned a = lowest(todo);
      todo = without_lowest(todo);
      for (std::uint64_t near = left & reach_.from(a, kHere); near != 0; near = without_lowest(near)) {
        const unsigned b = lowest(near);
        if (!reach_.near(here.at[a], here.at[b]) || !policy_.join(here.voxel[a], here.voxel[b])) continue;
        part |= cell_bit(b);
        todo |= cell_bit(b);
        left &= ~cell_bit(b);
      }
    }
    here.part[here.parts++] = part;
  }
}

/// Nodes for the parts. Each takes the label of the old node that it shares most cells with, the first one of
/// equals.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::renew_nodes(BlockIndex block, const Here& here) {
  const unsigned shown = labelling_.shown();
  std::array<std::uint16_t, Block::kCells> label;
  unsigned same = 0;
  for (unsigned i = 0; i < here.parts; ++i) {
    unsigned most = 0;
    label[i] = kNoLabel;
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
      const unsigned shared = bits_in(graph_[node].cells & here.part[i]);
      if (shared <= most) continue;
      most = shared;
      label[i] = graph_[node].label[shown];
    }
  }
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) ++same;
  if (same == here.parts) {
    unsigned i = 0;
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next, ++i) {
      graph_[node].cells = here.part[i];
      graph_[node].voxels = static_cast<std::uint8_t>(bits_in(here.part[i]));
      graph_[node].label[shown] = label[i];
    }
    return;
  }
  graph_.give(block);
  NodeIndex last = kNoNode;
  for (unsigned i = 0; i < here.parts; ++i) {
    const NodeIndex node = graph_.take(block, here.part[i]);
    if (node == kNoNode) return;
    graph_[node].label[shown] = label[i];
    if (last == kNoNode) {
      graph_.set_first(block, node);
    } else {
      graph_[last].next = node;
    }
    last = node;
  }
}

/// Tests the fragments of the block that is looked at against those of one beside it, until all that can
/// touch do.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::connect(const RollingGrid& grid, BlockIndex index, const Here& here, BlockIndex other,
                                int direction) {
  const Block& block = grid.block(other);
  std::uint64_t there = 0;
  for (NodeIndex node = graph_.first(other); node != kNoNode; node = graph_[node].next)
    there |= graph_[node].cells;
  there &= reach_.rim(26 - direction);
  for (NodeIndex node = graph_.first(index); node != kNoNode; node = graph_[node].next) {
    std::uint64_t open = there;
    for (std::uint64_t mine = graph_[node].cells & reach_.rim(direction); mine != 0 && open != 0;
         mine = without_lowest(mine)) {
      const unsigned a = lowest(mine);
      for (std::uint64_t near = open & reach_.from(a, direction); near != 0; near = without_lowest(near)) {
        const unsigned b = lowest(near);
        const std::uint32_t slot = block.slot(block.rank(b));
        if (!reach_.near(here.at[a], from_next(unit_point(grid.voxels()[slot], b), direction)) ||
            !policy_.join(here.voxel[a], policy_.load(grid, slot)))
          continue;
        const NodeIndex found = graph_.holder(other, b);
        open &= ~graph_[found].cells;
        near &= open | cell_bit(b);
        if (direction > kHere) {
          graph_.connect(node, direction, found);
        } else {
          graph_.connect(found, 26 - direction, node);
        }
      }
    }
  }
}

}  // namespace sortie::mapping
