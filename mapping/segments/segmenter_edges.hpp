// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's work between two blocks: which of their fragments touch. Included by
// mapping/segments/segmenter.hpp only.
#pragma once

#include "mapping/segments/segmenter_engine.hpp"

namespace sortie::mapping {

/// A voxel of the block that is looked at, as the block beside sees it.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Own {
  UnitPoint at;
  typename Policy::Voxel voxel;
};

template <SegmentationPolicy Policy>
typename Segmenter<Policy>::Own Segmenter<Policy>::own_voxel(const RollingGrid& grid, const Here& here,
                                                             const Beside& beside, unsigned cell) const {
  const Block& block = grid.block(here.index);
  const std::uint32_t slot = block.slot(block.rank(cell));
  const UnitPoint p = unit_point(grid.voxels()[slot], cell);
  return {{p.x - beside.shift.x, p.y - beside.shift.y, p.z - beside.shift.z}, policy_.load(grid, slot)};
}

/// Whether it and a core of the block beside make an edge.
template <SegmentationPolicy Policy>
bool Segmenter<Policy>::test(const RollingGrid& grid, const Beside& beside, const Own& own,
                             unsigned b) const {
  const Block& block = grid.block(beside.index);
  const std::uint32_t slot = block.slot(block.rank(b));
  if (!reach_.near(own.at, unit_point(grid.voxels()[slot], b))) return false;
  const typename Policy::Voxel its = policy_.load(grid, slot);
  return policy_.core(its) && policy_.join(own.voxel, its);
}

/// An edge that a moved voxel makes, the i-th of a part of its keeper: it holds, or another one between the
/// two fragments is looked for, or it goes.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::verify(const RollingGrid& grid, const Here& here, const Beside& beside,
                               NodeIndex keeper, NodeIndex part, unsigned i) {
  const FragmentEdge edge = graph_[part].edge[i];
  const bool forward = beside.forward();
  const unsigned a = forward ? edge.own() : edge.its();
  const unsigned b = forward ? edge.its() : edge.own();
  if ((here.cores >> a & 1) != 0 && test(grid, beside, own_voxel(grid, here, beside, a), b)) return;
  graph_[part].take_out(i);
  const std::uint64_t open = graph_[forward ? edge.to : keeper].cells & reach_.rim(26 - beside.direction);
  search(grid, here, beside, forward ? keeper : edge.to, open, true);
}

/// Edges that moved voxels make, but in directions in which somebody else will look at them.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::keep_edges(const RollingGrid& grid, const Here& here, const Pairs& pairs) {
  std::uint32_t backward = 0;
  for (NodeIndex node = graph_.first(here.index); node != kNoNode; node = graph_[node].next) {
    for (unsigned set = graph_[node].backward_set; set != 0; set &= set - 1) {
      const int direction = 12 - std::countr_zero(set);
      if ((here.moved & reach_.rim(direction)) != 0) backward |= 1u << direction;
    }
    for (NodeIndex part = node; part != kNoNode; part = graph_[part].extension) {
      // From the last one on: what is found meanwhile comes behind it.
      for (unsigned i = graph_[part].edges; i-- > 0;) {
        const FragmentEdge edge = graph_[part].edge[i];
        const int direction = edge.direction();
        if (((pairs.moved_at(direction) >> edge.its() | here.moved >> edge.own()) & 1) == 0 ||
            (pairs.waiting >> direction & 1) != 0)
          continue;
        const BlockIndex index = graph_[edge.to].block;
        verify(grid, here, {index, direction, 0, from_next({}, direction)}, node, part, i);
      }
    }
  }
  backward = (backward | (pairs.looked & ((1u << kHere) - 1))) & ~pairs.waiting;
  if (backward == 0) return;
  BlockIndex around[kDirections];
  ask(grid, here.index, backward, around);
  for (; backward != 0; backward &= backward - 1) {
    const int direction = std::countr_zero(backward);
    const BlockIndex index = around[direction];
    if (index == kNoBlock || !grid.is_next(grid.block(here.index), direction, index)) continue;
    const Beside beside{index, direction, 0, from_next({}, direction)};
    const std::uint64_t its = pairs.moved_at(direction);
    for (NodeIndex keeper = graph_.first(index); keeper != kNoNode; keeper = graph_[keeper].next) {
      for (NodeIndex part = keeper; part != kNoNode; part = graph_[part].extension) {
        for (unsigned i = graph_[part].edges; i-- > 0;) {
          const FragmentEdge edge = graph_[part].edge[i];
          if (edge.direction() == 26 - direction && ((here.moved >> edge.its() | its >> edge.own()) & 1) != 0)
            verify(grid, here, beside, keeper, part, i);
        }
      }
    }
  }
}

/// Looks for edges between a node that known edges no longer join with its component and the nodes around it.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::rejoin(const RollingGrid& grid, NodeIndex apart) {
  const BlockIndex block = graph_[apart].block;
  const Here here(block);
  BlockIndex around[kDirections];
  grid.around(grid.block(block), around);
  for (int direction = 0; direction < kDirections; ++direction) {
    const BlockIndex index = around[direction];
    if (index == kNoBlock) continue;
    work_[index].mixed |= direction == kHere ? BlockWork::kAllMixed : 1u << (26 - direction);
    if (direction == kHere) continue;
    std::uint64_t there = 0;
    for (NodeIndex node = graph_.first(index); node != kNoNode; node = graph_[node].next) {
      if (!labelling_.together(node, apart)) there |= graph_[node].cells;
    }
    there &= reach_.rim(26 - direction);
    if (there != 0) search(grid, here, {index, direction, 0, from_next({}, direction)}, apart, there, true);
  }
}

/// Cells beside whose fragments a node of this block touches.
template <SegmentationPolicy Policy>
std::uint64_t Segmenter<Policy>::joined(const Beside& beside, NodeIndex node) const {
  std::uint64_t cells = 0;
  if (beside.forward()) {
    for (NodeIndex part = node; part != kNoNode; part = graph_[part].extension) {
      for (const FragmentEdge& edge : graph_[part].known())
        if (edge.direction() == beside.direction) cells |= graph_[edge.to].cells;
    }
    return cells;
  }
  for (NodeIndex keeper = graph_.first(beside.index); keeper != kNoNode; keeper = graph_[keeper].next) {
    for (NodeIndex part = keeper; part != kNoNode; part = graph_[part].extension) {
      for (const FragmentEdge& edge : graph_[part].known())
        if (edge.to == node && edge.direction() == beside.kept()) cells |= graph_[keeper].cells;
    }
  }
  return cells;
}

/// Looks for edges between a node of this block and the fragments beside it with cells in `open`, until each
/// has one; of pairs that did not move only when `all` are asked for.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::search(const RollingGrid& grid, const Here& here, const Beside& beside,
                               NodeIndex node, std::uint64_t open, bool all) {
  std::uint64_t mine = graph_[node].cells & reach_.rim(beside.direction);
  if (!all && beside.moved == 0) mine &= here.moved;
  for (; mine != 0 && open != 0; mine = without_lowest(mine)) {
    const unsigned a = lowest(mine);
    std::uint64_t near = open & reach_.from(a, beside.direction);
    if (!all && (here.moved >> a & 1) == 0) near &= beside.moved;
    if (near == 0) continue;
    const Own own = own_voxel(grid, here, beside, a);
    for (; near != 0; near = without_lowest(near)) {
      const unsigned b = lowest(near);
      if (!test(grid, beside, own, b)) continue;
      const NodeIndex found = graph_.holder(beside.index, b);
      open &= ~graph_[found].cells;
      near &= open | cell_bit(b);
      const bool kept = beside.forward()
                            ? graph_.connect(node, FragmentEdge::of(found, beside.direction, a, b))
                            : graph_.connect(found, FragmentEdge::of(node, beside.kept(), b, a));
      if (labelling_.running()) {
        // An edge that is lost here is none: the next labelling finds the two apart, and asks for it again.
        labelling_.joined(node, found);
      } else if (!kept) {
        want(here.index);
      }
    }
  }
}

/// Segment of the core near a voxel that suits it best; of equals, the oldest one.
template <SegmentationPolicy Policy>
SegmentId Segmenter<Policy>::taken_in(const RollingGrid& grid, BlockIndex index,
                                      unsigned cell) const requires TakingPolicy<Policy> {
  const Block& block = grid.block(index);
  const std::uint32_t slot = block.slot(block.rank(cell));
  const UnitPoint own = unit_point(grid.voxels()[slot], cell);
  const auto voxel = policy_.load(grid, slot);
  BlockIndex around[kDirections];
  grid.around(block, around);
  std::int64_t most = -1;
  SegmentId segment = kNoSegment;
  for (int direction = 0; direction < kDirections; ++direction) {
    const BlockIndex there = around[direction];
    if (there == kNoBlock) continue;
    for (NodeIndex node = graph_.first(there); node != kNoNode; node = graph_[node].next) {
      for (std::uint64_t near = graph_[node].cells & reach_.from(cell, direction); near != 0;
           near = without_lowest(near)) {
        const unsigned b = lowest(near);
        const std::uint32_t its = grid.block(there).slot(grid.block(there).rank(b));
        if (!reach_.near(own, from_next(unit_point(grid.voxels()[its], b), direction))) continue;
        const std::int64_t affinity = policy_.affinity(voxel, policy_.load(grid, its));
        const SegmentId id = labelling_.id(graph_[node].label[labelling_.shown()]);
        if (affinity < 0 || affinity < most || (affinity == most && id >= segment)) continue;
        most = affinity;
        segment = id;
      }
    }
  }
  return segment;
}

}  // namespace sortie::mapping
