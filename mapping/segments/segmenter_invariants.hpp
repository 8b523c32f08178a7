// SPDX-License-Identifier: BSD-3-Clause
// What holds between any two steps of the segmenter, wherever a budget stops it and whatever the grid does
// before it goes on. Included by mapping/segments/segmenter.hpp only.
//
// Between two steps blocks may come, go and come back under the same number, voxels may move, and the state
// may be stored and read. So a step may rely on these sentences alone, and not on what the step before it
// found:
//
//   queue    A block is in the queue once or not at all (`queued` is 0). The first `left_of_cycle_` carry the
//            tag of the cycle that runs, all others that of the next one. A block that left stays in line.
//   nodes    A block that is not in use has no fragments, and nothing that moved, is wanting or is unmixed.
//            Fragments of a block hold active cells, each at most one. A node that the labelling calls
//            apart() is one of them: whoever gives it back says so first (Labelling::leaving()).
//   moved    What changed since a block was looked at is in `moved`, and then the block is queued. All other
//            cores are in fragments, all other cells of fragments are cores, and two fragments of a block do
//            not touch but by cells in `moved`; or the block is `wanting`.
//   looked   `looked`, `renewed` and `cycle` tell what the look in cycle `cycle` found: cells that had moved,
//            and whether fragments were fresh. They count only for blocks with the present cycle's number.
//            The low bits come again and a number may stand for another block by then: both only lead to more
//            tests.
//   waiting  A pair with a block that the same cycle is still to look at is left to that look: it takes the
//            other's `looked` and `renewed` for its own. Where the block leaves before, the pair is gone.
//   edges    The two voxels of every known edge join; or one of them is in `moved`, or in `looked` of a block
//            that left the pair waiting, or belongs to a wanting block.
//   names    Two fragments of blocks side by side that touch have an edge, or one name (an edge within a
//            component need not be known: the labelling asks for it when known ones no longer suffice); or a
//            voxel of those that touch is as above; or one is fresh and its block left the pair waiting.
//   mixed    Two blocks side by side with fragments of two names, or with fresh ones, have each other's bits
//            in `mixed`. More bits are set than need be.
//   wanting  Nothing was kept of what found no room but this bit, which makes the next look at the block one
//            at all of its cells. `wanting_` of them are in use. While there is no room none is looked for;
//            when there is, all get in line before the next cycle.
//
// Labels and names of a labelling that runs are in the making: `names` and `mixed` hold before it and after
// it.
#pragma once

#include "mapping/segments/segmenter_engine.hpp"

namespace sortie::mapping {

/// Whether a look that is to come tests these cells of `a` against block `b`.
template <SegmentationPolicy Policy>
bool Segmenter<Policy>::awaits(BlockIndex a, std::uint64_t cells, BlockIndex b) const {
  const BlockWork& work = work_[a];
  if (work.wanting != 0 || (work.moved & cells) != 0) return true;
  const bool left_to_b =
      work.cycle == static_cast<std::uint8_t>(cycle_) && left_of_cycle_ > 0 && work_[b].queued == tag(cycle_);
  if (!left_to_b) return false;
  if ((work.looked & cells) != 0) return true;
  for (NodeIndex node = graph_.first(a); node != kNoNode; node = graph_[node].next)
    if (work.renewed != 0 && graph_[node].name == kNoNode && (graph_[node].cells & cells) != 0) return true;
  return false;
}

template <SegmentationPolicy Policy>
const char* Segmenter<Policy>::broken(const RollingGrid& grid) const {
  if (status_ != Status::ok) return nullptr;
  if (left_of_cycle_ > queue_size_ || queue_size_ > queue_.size()) return "queue: more than there can be";
  for (std::uint32_t i = 0; i < queue_size_; ++i) {
    const std::uint32_t cycle = i < left_of_cycle_ ? cycle_ : cycle_ + 1;
    if (work_[queue_[(queue_first_ + i) % queue_.size()]].queued != tag(cycle)) return "queue: a wrong tag";
  }
  std::uint32_t queued = 0;
  std::uint32_t wanting = 0;
  for (std::uint32_t i = 0; i < grid.block_numbers(); ++i) {
    const auto index = static_cast<BlockIndex>(i);
    queued += work_[i].queued != 0 ? 1 : 0;
    wanting += work_[i].wanting;
    if (const char* what = broken_block(grid, index); what != nullptr) return what;
    if (!grid.block(index).in_use()) continue;
    BlockIndex around[kDirections];
    grid.around(grid.block(index), around);
    for (int direction = kHere + 1; direction < kDirections; ++direction) {
      if (around[direction] == kNoBlock) continue;
      if (const char* what = broken_pair(grid, index, around[direction], direction); what != nullptr)
        return what;
    }
  }
  if (queued != queue_size_) return "queue: a tag without a place";
  if (wanting != wanting_) return "wanting: a wrong count";
  const NodeIndex apart = labelling_.apart();
  if (apart != kNoNode && (graph_[apart].cells == 0 || graph_[apart].block == kNoBlock))
    return "nodes: one that left is to be looked at";
  return nullptr;
}

/// What does not hold within a block.
template <SegmentationPolicy Policy>
const char* Segmenter<Policy>::broken_block(const RollingGrid& grid, BlockIndex index) const {
  const Block& block = grid.block(index);
  const BlockWork& work = work_[index];
  if (!block.in_use()) {
    const bool empty = graph_.first(index) == kNoNode && work.moved == 0 && work.wanting == 0 &&
                       work.mixed == BlockWork::kAllMixed && work.slack == 0;
    return empty ? nullptr : "nodes: a block that left still has something";
  }
  if (work.moved != 0 && work.queued == 0) return "moved: a block that does not wait";
  std::uint64_t held = 0;
  for (NodeIndex node = graph_.first(index); node != kNoNode; node = graph_[node].next) {
    const FragmentNode& n = graph_[node];
    if (n.cells == 0 || n.block != index || (n.cells & held) != 0 || (n.cells & ~block.active) != 0)
      return "nodes: cells that it cannot hold";
    held |= n.cells;
  }
  if (work.wanting != 0) return nullptr;
  for (std::uint64_t rest = block.active & ~work.moved; rest != 0; rest = without_lowest(rest)) {
    const unsigned a = lowest(rest);
    const std::uint32_t slot = block.slot(block.rank(a));
    const typename Policy::Voxel voxel = policy_.load(grid, slot);
    if (policy_.core(voxel) != ((held & cell_bit(a)) != 0))
      return "moved: a core without fragment, or none in one";
    const NodeIndex own = graph_.holder(index, a);
    if (own == kNoNode) continue;
    for (std::uint64_t near = held & ~graph_[own].cells & ~work.moved & reach_.from(a, kHere); near != 0;
         near = without_lowest(near)) {
      const std::uint32_t its = block.slot(block.rank(lowest(near)));
      if (reach_.near(unit_point(grid.voxels()[slot], a), unit_point(grid.voxels()[its], lowest(near))) &&
          policy_.join(voxel, policy_.load(grid, its)))
        return "moved: two fragments of a block touch";
    }
  }
  return nullptr;
}

/// What does not hold between two blocks side by side, the second one in a forward direction.
template <SegmentationPolicy Policy>
const char* Segmenter<Policy>::broken_pair(const RollingGrid& grid, BlockIndex a, BlockIndex b,
                                           int direction) const {
  const bool named = !labelling_.running();
  if (named && are_mixed(a, b) &&
      ((work_[a].mixed >> direction & 1) == 0 || (work_[b].mixed >> (26 - direction) & 1) == 0))
    return "mixed: a bit is missing";
  const Here here(a);
  const Beside beside{b, direction, 0, from_next({}, direction)};
  const auto join = [&](unsigned own, unsigned its) {
    const Own voxel = own_voxel(grid, here, beside, own);
    return policy_.core(voxel.voxel) && test(grid, beside, voxel, its);
  };
  for (NodeIndex node = graph_.first(a); node != kNoNode; node = graph_[node].next) {
    for (NodeIndex part = node; part != kNoNode; part = graph_[part].extension) {
      for (const FragmentEdge& edge : graph_[part].known()) {
        if (edge.direction() != direction) continue;
        if (graph_[edge.to].block != b || graph_[edge.to].cells == 0) return "edges: to a node that left";
        if (!join(edge.own(), edge.its()) && !awaits(a, cell_bit(edge.own()), b) &&
            !awaits(b, cell_bit(edge.its()), a))
          return "edges: one that does not hold";
      }
    }
    if (!named) continue;
    const std::uint64_t known = joined(beside, node);
    for (NodeIndex other = graph_.first(b); other != kNoNode; other = graph_[other].next) {
      if ((graph_[other].cells & known) != 0) continue;
      if (graph_[node].name != kNoNode && graph_[node].name == graph_[other].name) continue;
      for (std::uint64_t mine = graph_[node].cells; mine != 0; mine = without_lowest(mine)) {
        const unsigned own = lowest(mine);
        for (std::uint64_t near = graph_[other].cells & reach_.from(own, direction); near != 0;
             near = without_lowest(near)) {
          if (join(own, lowest(near)) && !awaits(a, cell_bit(own), b) &&
              !awaits(b, cell_bit(lowest(near)), a))
            return "names: two that touch are strangers";
        }
      }
    }
  }
  return nullptr;
}

}  // namespace sortie::mapping
