// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's work within one block: which voxels hang together, and the fragments that stand for them.
// Included by mapping/segments/segmenter.hpp only.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>

#include "mapping/segments/segmenter.hpp"

namespace sortie::mapping {

/// The block that is looked at, and the fragments that it has now.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Here {
  BlockIndex index;
  std::uint64_t moved;
  std::uint64_t cores;   ///< cells of all parts
  std::uint64_t fresh;   ///< those of fragments that were not there before
  std::int64_t longest;  ///< squared distance of the farthest of the links that hold parts together
  unsigned parts;
  std::uint64_t part[Block::kCells];  ///< filled where there is something: clearing would take longer

  explicit Here(BlockIndex block) : index(block), moved(0), cores(0), fresh(0), longest(0), parts(0) {}
};

/// A block beside the one that is looked at.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Beside {
  BlockIndex index{};
  int direction{};
  std::uint64_t moved{};  ///< of its voxels, since the pair was tested
  UnitPoint shift;

  bool forward() const { return direction > kHere; }
  /// Direction in which the block that keeps the edges sees the other one.
  int kept() const { return forward() ? direction : 26 - direction; }
};

/// The blocks around in directions in which there is more than one component.
template <SegmentationPolicy Policy>
struct Segmenter<Policy>::Pairs {
  std::uint32_t open{};              ///< an edge may have come
  std::uint32_t waiting{};           ///< the other block will be looked at, and then the pair
  std::uint32_t looked{};            ///< voxels of the other block moved, and it was looked at before
  std::uint64_t moved[kDirections];  ///< these voxels, where a bit of `open` or `looked` is set

  Pairs() {}  // `moved` is filled where it is needed
  std::uint64_t moved_at(int direction) const {
    return (looked >> direction & 1) != 0 ? moved[direction] : 0;
  }
};

/// How far voxels may drift in all until a link as long as the longest one can break.
template <SegmentationPolicy Policy>
std::uint16_t Segmenter<Policy>::slack_of(std::int64_t longest) const {
  const double room = std::floor(std::sqrt(static_cast<double>(reach_.squared_radius()))) -
                      std::ceil(std::sqrt(static_cast<double>(longest)));
  return static_cast<std::uint16_t>(std::clamp(room / kDriftStep, 0.0, 65535.0));
}

/// Connected parts of the block by themselves.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::fragment(const RollingGrid& grid, Here& here) {
  BlockWork& own = work_[here.index];
  if (own.slack == 0) {
    find_parts(grid, here);
    own.slack = slack_of(here.longest);
    return;
  }
  // What hung together still does. Only a voxel that moved can join two parts, and only one that was none can
  // be another one.
  for (NodeIndex node = graph_.first(here.index); node != kNoNode; node = graph_[node].next) {
    here.part[here.parts++] = graph_[node].cells;
    here.cores |= graph_[node].cells;
  }
  const Block& block = grid.block(here.index);
  for (std::uint64_t rest = here.moved & block.active & ~here.cores; rest != 0; rest = without_lowest(rest)) {
    const std::uint64_t cell = rest & (~rest + 1);
    if (!policy_.core(policy_.load(grid, block.slot(block.rank(lowest(rest)))))) continue;
    here.part[here.parts++] = cell;
    here.cores |= cell;
  }
  if (here.parts < 2) return;
  join_parts(grid, here);
  own.slack = std::min(own.slack, slack_of(here.longest));
}

/// Puts parts together that a moved voxel joins.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::join_parts(const RollingGrid& grid, Here& here) {
  const Block& block = grid.block(here.index);
  for (std::uint64_t rest = here.moved & here.cores; rest != 0; rest = without_lowest(rest)) {
    const unsigned a = lowest(rest);
    unsigned p = 0;
    while ((here.part[p] >> a & 1) == 0) ++p;
    std::uint64_t open = here.cores & ~here.part[p] & reach_.from(a, kHere);
    if (open == 0) continue;
    const std::uint32_t slot = block.slot(block.rank(a));
    const UnitPoint at = unit_point(grid.voxels()[slot], a);
    const typename Policy::Voxel voxel = policy_.load(grid, slot);
    while (open != 0) {
      const std::uint64_t beside = open & reach_.beside(a);
      const std::uint64_t close = open & reach_.close(a);
      const unsigned b = lowest(beside != 0 ? beside : close != 0 ? close : open);
      open &= ~cell_bit(b);
      const std::uint32_t its = block.slot(block.rank(b));
      const std::int64_t distance = squared_distance(at, unit_point(grid.voxels()[its], b));
      if (distance > reach_.squared_radius() || !policy_.join(voxel, policy_.load(grid, its))) continue;
      here.longest = std::max(here.longest, distance);
      unsigned q = 0;
      while ((here.part[q] >> b & 1) == 0) ++q;
      open &= ~here.part[q];
      here.part[p] |= here.part[q];
      here.part[q] = here.part[--here.parts];
      if (p == here.parts) p = q;
    }
  }
}

/// Parts from nothing but the voxels, in the order of their first cells.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::find_parts(const RollingGrid& grid, Here& here) {
  UnitPoint at[Block::kCells];
  typename Policy::Voxel voxel[Block::kCells];
  const Block& block = grid.block(here.index);
  unsigned rank = 0;
  for (std::uint64_t rest = block.occupied; rest != 0; rest = without_lowest(rest), ++rank) {
    const unsigned cell = lowest(rest);
    if ((block.active & cell_bit(cell)) == 0) continue;
    const std::uint32_t slot = block.slot(rank);
    at[cell] = unit_point(grid.voxels()[slot], cell);
    voxel[cell] = policy_.load(grid, slot);
    if (policy_.core(voxel[cell])) here.cores |= cell_bit(cell);
  }
  // Cells that share a face come first, then those that touch: there nearly every test finds something, what
  // is found is not asked for again, and short links last longer.
  std::uint64_t left = here.cores;
  while (left != 0) {
    std::uint64_t part = left & (~left + 1);
    std::uint64_t pending[3] = {part, part, part};
    left ^= part;
    while (left != 0 && (pending[0] | pending[1] | pending[2]) != 0) {
      const unsigned far = pending[0] != 0 ? 0 : pending[1] != 0 ? 1 : 2;
      const unsigned a = lowest(pending[far]);
      pending[far] = without_lowest(pending[far]);
      const std::uint64_t reach = far == 0   ? reach_.beside(a)
                                  : far == 1 ? reach_.close(a)
                                             : reach_.from(a, kHere);
      std::uint64_t found = 0;
      for (std::uint64_t near = left & reach; near != 0; near = without_lowest(near)) {
        const unsigned b = lowest(near);
        const std::int64_t distance = squared_distance(at[a], at[b]);
        if (distance > reach_.squared_radius() || !policy_.join(voxel[a], voxel[b])) continue;
        here.longest = std::max(here.longest, distance);
        found |= cell_bit(b);
      }
      part |= found;
      left &= ~found;
      for (std::uint64_t& more : pending) more |= found;
    }
    here.part[here.parts++] = part;
  }
}

/// Fragments for the parts. One of before stays, with its edges, where a part is it with more or fewer cells;
/// the others go. A part that none stays for gets a fresh one with the label of the old one that it shares
/// most cells with; of equals, of the one with the first cell.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::renew_nodes(const RollingGrid& grid, Here& here) {
  const NodeIndex only = graph_.first(here.index);
  if (here.parts == 1 && only != kNoNode && graph_[only].next == kNoNode &&
      (graph_[only].cells & here.part[0]) != 0) {
    set_cells(only, here.part[0]);
    return;
  }
  std::uint64_t met = 0;    // parts that some old fragment has a share in
  std::uint64_t again = 0;  // those that two have
  for (NodeIndex node = only; node != kNoNode; node = graph_[node].next) {
    for (unsigned i = 0; i < here.parts; ++i) {
      if ((graph_[node].cells & here.part[i]) == 0) continue;
      again |= met & cell_bit(i);
      met |= cell_bit(i);
    }
  }
  std::uint64_t kept = 0;
  std::array<NodeIndex, Block::kCells> gone;
  unsigned going = 0;
  NodeIndex last = kNoNode;
  for (NodeIndex node = only; node != kNoNode;) {
    const NodeIndex next = graph_[node].next;
    const std::uint64_t cells = graph_[node].cells & here.cores;
    unsigned i = 0;
    while (i < here.parts && (here.part[i] & cells) == 0) ++i;
    if (i < here.parts && (cells & ~here.part[i]) == 0 && (again & cell_bit(i)) == 0) {
      kept |= cell_bit(i);
      set_cells(node, here.part[i]);
      graph_.link(here.index, last, node);
      last = node;
    } else {
      gone[going++] = node;
    }
    node = next;
  }
  graph_.link(here.index, last, kNoNode);
  const unsigned shown = labelling_.shown();
  for (unsigned i = 0; i < here.parts; ++i) {
    if ((kept & cell_bit(i)) != 0) continue;
    const NodeIndex node = graph_.take(here.index, here.part[i]);
    if (node == kNoNode) {
      want(here.index);
      break;
    }
    here.fresh |= here.part[i];
    unsigned most = 0;
    unsigned first = Block::kCells;
    for (unsigned k = 0; k < going; ++k) {
      const unsigned shared = bits_in(graph_[gone[k]].cells & here.part[i]);
      const unsigned begin = lowest(graph_[gone[k]].cells);
      if (shared < most || shared == 0 || (shared == most && begin > first)) continue;
      most = shared;
      first = begin;
      graph_[node].label[shown] = graph_[gone[k]].label[shown];
    }
    graph_.link(here.index, last, node);
    last = node;
  }
  for (unsigned k = 0; k < going; ++k) drop(grid, here.index, gone[k]);
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::set_cells(NodeIndex node, std::uint64_t cells) {
  graph_[node].cells = cells;
  graph_[node].voxels = static_cast<std::uint8_t>(bits_in(cells));
}

/// Gives a fragment back that its block no longer lists, and all edges to it.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::drop(const RollingGrid& grid, BlockIndex block, NodeIndex node) {
  const BlockAt at = BlockAt::from_key(grid.block(block).key);
  for (unsigned set = graph_[node].backward_set; set != 0; set &= set - 1) {
    const int direction = 12 - std::countr_zero(set);
    const BlockIndex index = grid.find(at.next(direction));
    if (index != kNoBlock) graph_.disconnect(index, 26 - direction, node);
  }
  graph_.give(node);
}

}  // namespace sortie::mapping
