// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's work on one block: its fragments, and which fragments around they touch. Included by
// mapping/segmenter.hpp only.
#pragma once

#include "mapping/segmenter.hpp"

namespace sortie::mapping {

/// The block that is looked at: its voxels laid out by cell, and the fragments they make.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Here {
  std::uint64_t cores;
  std::uint64_t moved;
  unsigned parts;
  // Filled where there is something, not set to anything elsewhere: that would take longer than the rest.
  UnitPoint at[Block::kCells];
  typename Policy::Voxel voxel[Block::kCells];
  std::uint64_t part[Block::kCells];

  Here() : cores(0), moved(0), parts(0) {}
};

template <SegmentationPolicy Policy>
SegmenterStep Segmenter<Policy>::update(const RollingGrid& grid, std::uint32_t tick) {
  SegmenterStep step;
  const std::uint32_t most = config_.units > 0 ? config_.units : 0xffffffffu - kBlockUnits;
  while (status_ == Status::ok && step.units < most) {
    if (labelling_.apart() != kNoNode) {
      rejoin(grid, labelling_.apart());
      labelling_.checked();
      step.units += kBlockUnits;
    } else if (labelling_.running()) {
      step.units += labelling_.run(graph_, grid.blocks(), most - step.units);
      if (!labelling_.running()) graph_.hold(false);
    } else if (left_of_cycle_ > 0) {
      drained_ = --left_of_cycle_ == 0;
      --queue_size_;
      const BlockIndex block = queue_[queue_first_];
      queue_first_ = queue_first_ + 1 < queue_.size() ? queue_first_ + 1 : 0;
      work_[block].queued = 0;
      // What the next two need is fetched meanwhile.
      if (left_of_cycle_ > 1) {
        const BlockIndex next = queue_[queue_first_];
        grid.prefetch_around(grid.block(next));
        grid.prefetch_normals(grid.block(next), grid.block(next).active);
        graph_.prefetch_nodes(next);
        __builtin_prefetch(&grid.block(queue_[(queue_first_ + 1) % queue_.size()]));
      }
      if (!grid.block(block).in_use()) continue;
      look_at(grid, block);
      ++step.blocks;
      step.units += kBlockUnits;
    } else if (changed_ && (drained_ || queue_size_ == 0)) {
      changed_ = drained_ = false;
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
  if (status_ != Status::ok) return;
  work_[block].moved = 0;
  work_[block].settled = false;
  if (graph_.first(block) == kNoNode) return;
  BlockIndex around[kDirections];
  grid.around(grid.block(block), around);
  for (int direction = 0; direction < kHere; ++direction) {
    if (around[direction] != kNoBlock) graph_.disconnect(around[direction], 26 - direction);
  }
  graph_.give(block);
  changed_ = true;
}

/// A block beside the one that is looked at.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Beside {
  BlockIndex index{};
  int direction{};
  std::uint64_t there{};  ///< cells of its fragments that can be reached
  std::uint64_t moved{};  ///< of its voxels, since the pair was tested
  UnitPoint shift;

  bool forward() const { return direction > kHere; }
  /// Direction in which the block that keeps the edges sees the other one.
  int kept() const { return forward() ? direction : 26 - direction; }
};

template <SegmentationPolicy Policy>
void Segmenter<Policy>::look_at(const RollingGrid& grid, BlockIndex block) {
  Here here;
  BlockWork& own = work_[block];
  here.moved = own.looked = own.moved;
  own.moved = 0;
  own.cycle = static_cast<std::uint8_t>(cycle_);
  BlockIndex around[kDirections];
  if (!own.settled) {
    grid.ask_around(grid.block(block), around);
    for (const BlockIndex index : around) {
      if (index == kNoBlock) continue;
      __builtin_prefetch(&work_[index]);
      graph_.prefetch(index);
    }
  }
  fragment(grid, block, here);
  own.renewed = !keep_nodes(block, here);
  if (!own.renewed && own.settled) return keep_edges(grid, block, here);
  if (own.settled) grid.ask_around(grid.block(block), around);
  look_beside(grid, block, here, around);
}

/// Name of the component that all fragments of a block belong to; kNoNode when there are two, or a fresh one.
template <SegmentationPolicy Policy>
NodeIndex Segmenter<Policy>::one_name(BlockIndex block) const {
  NodeIndex name = kNoNode;
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
    const NodeIndex its = graph_[node].name;
    if (its == kNoNode || (name != kNoNode && its != name)) return kNoNode;
    name = its;
  }
  return name;
}

/// Edges to the blocks around.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::look_beside(const RollingGrid& grid, BlockIndex block, const Here& here,
                                    const BlockIndex (&around)[kDirections]) {
  BlockWork& own = work_[block];
  std::uint64_t cells = here.cores | here.moved;
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next)
    cells |= graph_[node].cells;
  if (own.renewed) renew_nodes(block, here);
  const NodeIndex name = one_name(block);
  own.settled = name != kNoNode;
  for (int direction = 0; direction < kDirections; ++direction) {
    const BlockIndex index = around[direction];
    if (index == kNoBlock || direction == kHere || !grid.is_next(grid.block(block), direction, index) ||
        graph_.first(index) == kNoNode)
      continue;
    BlockWork& other = work_[index];
    const bool one = name != kNoNode && one_name(index) == name;
    if (!one) own.settled = other.settled = false;
    if ((cells & reach_.rim(direction)) == 0) continue;
    const bool looked = other.cycle == own.cycle;
    const bool all = own.renewed || (looked && other.renewed);
    // Where nothing within reach of the border moved, nothing changes.
    const std::uint64_t its = looked ? other.looked & reach_.rim(26 - direction) : 0;
    if (!all && its == 0 && (here.moved & reach_.rim(direction)) == 0) continue;
    Beside beside{index, direction, 0, its, from_next({}, direction)};
    if (own.renewed && !beside.forward()) graph_.disconnect(index, beside.kept());
    // One that is still to be looked at before the labelling tests the pair itself.
    if (!one && other.queued == tag(cycle_)) continue;
    for (NodeIndex node = graph_.first(index); node != kNoNode; node = graph_[node].next)
      beside.there |= graph_[node].cells;
    beside.there &= reach_.rim(26 - direction);
    if (!all) verify(grid, block, here, beside);
    if (one) continue;
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
      const std::uint64_t open = all ? beside.there : beside.there & ~joined(beside, node);
      if (open != 0) search(grid, here, beside, node, open, all);
    }
  }
}

/// Voxels of a block, laid out by cell.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::load(const RollingGrid& grid, BlockIndex index, Here& here) const {
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
}

/// Connected parts of the block by themselves, in the order of their first cells.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::fragment(const RollingGrid& grid, BlockIndex index, Here& here) {
  load(grid, index, here);
  // Cells that touch come first: there nearly every test finds something, and what is found is not asked for
  // again.
  std::uint64_t left = here.cores;
  while (left != 0) {
    std::uint64_t part = left & (~left + 1);
    std::uint64_t pending = part;
    std::uint64_t wide = part;
    left ^= part;
    while (left != 0 && (pending | wide) != 0) {
      const bool narrow = pending != 0;
      const unsigned a = lowest(narrow ? pending : wide);
      (narrow ? pending : wide) &= ~cell_bit(a);
      for (std::uint64_t near = left & (narrow ? reach_.close(a) : reach_.from(a, kHere)); near != 0;
           near = without_lowest(near)) {
        const unsigned b = lowest(near);
        if (!reach_.near(here.at[a], here.at[b]) || !policy_.join(here.voxel[a], here.voxel[b])) continue;
        part |= cell_bit(b);
        pending |= cell_bit(b);
        wide |= cell_bit(b);
        left &= ~cell_bit(b);
      }
    }
    here.part[here.parts++] = part;
  }
}

/// True when every part is one of the fragments of before with more or fewer cells, and none is left over:
/// they stay, then, and so do the edges to them. A cell that came or went is one that moved.
template <SegmentationPolicy Policy>
bool Segmenter<Policy>::keep_nodes(BlockIndex block, const Here& here) {
  std::array<unsigned, Block::kCells> part_of;
  unsigned nodes = 0;
  std::uint64_t taken = 0;
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
    if (nodes == here.parts) return false;
    unsigned part = 0;
    const std::uint64_t cells = graph_[node].cells & here.cores;
    while (part < here.parts && (here.part[part] & cells) == 0) ++part;
    if (part == here.parts || (taken & cell_bit(part)) != 0 || (cells & ~here.part[part]) != 0) return false;
    taken |= cell_bit(part);
    part_of[nodes++] = part;
  }
  if (nodes != here.parts) return false;
  unsigned i = 0;
  for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next, ++i) {
    graph_[node].cells = here.part[part_of[i]];
    graph_[node].voxels = static_cast<std::uint8_t>(bits_in(graph_[node].cells));
  }
  return true;
}

/// Nodes for the parts. Each takes the label of the old node that it shares most cells with; of equals, of
/// the one with the first cell.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::renew_nodes(BlockIndex block, const Here& here) {
  const unsigned shown = labelling_.shown();
  std::array<std::uint16_t, Block::kCells> label;
  for (unsigned i = 0; i < here.parts; ++i) {
    unsigned most = 0;
    unsigned first = Block::kCells;
    label[i] = kNoLabel;
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
      const unsigned shared = bits_in(graph_[node].cells & here.part[i]);
      const unsigned begin = lowest(graph_[node].cells);
      if (shared < most || shared == 0 || (shared == most && begin > first)) continue;
      most = shared;
      first = begin;
      label[i] = graph_[node].label[shown];
    }
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

}  // namespace sortie::mapping
