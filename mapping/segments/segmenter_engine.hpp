// SPDX-License-Identifier: BSD-3-Clause
// The segmenter's work on one block: its fragments, and which fragments around they touch. Included by
// mapping/segments/segmenter.hpp only.
#pragma once

#include "mapping/segments/segmenter_fragments.hpp"

namespace sortie::mapping {

template <SegmentationPolicy Policy>
inline void Segmenter<Policy>::mark(BlockIndex block, std::uint64_t moved, std::uint16_t drift) {
  if (status_ != Status::ok || moved == 0) return;
  work_[block].moved |= moved;
  std::uint16_t& slack = work_[block].slack;
  slack = static_cast<std::uint16_t>(slack > drift ? slack - drift : 0);
  enqueue(block);
}

template <SegmentationPolicy Policy>
inline void Segmenter<Policy>::enqueue(BlockIndex block) {
  if (work_[block].queued != 0) return;
  work_[block].queued = tag(cycle_ + 1) & 3;
  queue_[(queue_first_ + queue_size_++) % queue_.size()] = block;
}

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
      if (labelling_.running()) continue;
      graph_.hold(false);
      changed_ = changed_ || labelling_.finds_slots();
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
        grid.prefetch_normals(grid.block(next));
        graph_.prefetch_nodes(next);
        __builtin_prefetch(&grid.block(queue_[(queue_first_ + 1) % queue_.size()]));
      }
      if (!grid.block(block).in_use()) {  // it left while it waited
        ++step.units;
        continue;
      }
      look_at(grid, block);
      ++step.blocks;
      step.units += kBlockUnits;
    } else if (changed_ && (drained_ || queue_size_ == 0)) {
      changed_ = drained_ = false;
      labelling_.start(tick);
      graph_.hold(true);
    } else if (sweep_left_ > 0) {
      step.units += sweep();
    } else if (wanting_ > 0 && !swept_ && graph_.room() > 0) {
      sweep_left_ = grid.block_numbers();
      swept_ = true;
    } else if (queue_size_ > 0) {
      ++cycle_;
      left_of_cycle_ = queue_size_;
      changed_ = true;
      swept_ = false;
    } else if (swept_) {
      swept_ = false;  // those that were found left
    } else {
      break;
    }
  }
  step.backlog = queue_size_;
  step.wanting = wanting_;
  const bool idle = queue_size_ == 0 && !changed_ && !labelling_.running();
  step.current = status_ == Status::ok && idle && wanting_ == 0 && labelling_.nameless() == 0;
  step.done = status_ != Status::ok || (idle && sweep_left_ == 0 && (wanting_ == 0 || graph_.room() == 0));
  if constexpr (kBlocksChecked > 0) {
    if (!read_ && grid.block_numbers() <= kBlocksChecked && broken(grid) != nullptr) __builtin_trap();
  }
  return step;
}

/// Some of the block numbers that are left are looked through: what wants room gets in line. Gives the units.
template <SegmentationPolicy Policy>
std::uint32_t Segmenter<Policy>::sweep() {
  constexpr std::uint32_t kAtOnce = 16;
  for (std::uint32_t i = 0; i < kAtOnce && sweep_left_ > 0; ++i) {
    const auto block = static_cast<BlockIndex>(--sweep_left_);
    if (work_[block].wanting != 0) enqueue(block);
  }
  return 1;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::want(BlockIndex block) {
  if (work_[block].wanting == 0) ++wanting_;
  work_[block].wanting = 1;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::want_no_more(BlockIndex block) {
  if (work_[block].wanting != 0) --wanting_;
  work_[block].wanting = 0;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::forget(const RollingGrid& grid, BlockIndex block) {
  if (status_ != Status::ok) return;
  work_[block].moved = 0;
  work_[block].mixed = BlockWork::kAllMixed;
  work_[block].slack = 0;
  want_no_more(block);
  if (graph_.first(block) == kNoNode) return;
  labelling_.leaving(graph_, block);
  BlockIndex around[kDirections];
  grid.around(grid.block(block), around);
  for (int direction = 0; direction < kHere; ++direction) {
    if (around[direction] != kNoBlock) graph_.disconnect(around[direction], 26 - direction);
  }
  graph_.give_all(block);
  changed_ = true;
}

template <SegmentationPolicy Policy>
void Segmenter<Policy>::look_at(const RollingGrid& grid, BlockIndex block) {
  Here here(block);
  BlockWork& own = work_[block];
  if (own.wanting != 0) {
    // What it has no fragment or edge for may be anywhere in it, and need not have moved since.
    own.moved = grid.block(block).active;
    own.mixed = BlockWork::kAllMixed;
    own.slack = 0;
    want_no_more(block);
  }
  here.moved = own.looked = own.moved;
  own.moved = 0;
  own.cycle = static_cast<std::uint8_t>(cycle_);
  BlockIndex around[kDirections];
  const std::uint32_t asked = own.mixed;
  ask(grid, block, asked, around);
  fragment(grid, here);
  for (std::uint32_t rest = asked; rest != 0; rest &= rest - 1) {
    const BlockIndex index = around[std::countr_zero(rest)];
    if (index != kNoBlock) graph_.prefetch_nodes(index);
  }
  renew_nodes(grid, here);
  own.renewed = here.fresh != 0;
  if (own.renewed) {
    own.mixed = BlockWork::kAllMixed;
    ask(grid, block, own.mixed & ~asked, around);
  }
  Pairs pairs;
  if (own.mixed != 0) survey(grid, here, around, pairs);
  keep_edges(grid, here, pairs);
  for (std::uint32_t rest = pairs.open; rest != 0; rest &= rest - 1) {
    const int direction = std::countr_zero(rest);
    const BlockIndex index = around[direction];
    const Beside beside{index, direction, pairs.moved[direction], from_next({}, direction)};
    const bool renewed = work_[index].cycle == own.cycle && work_[index].renewed != 0;
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next)
      look_from(grid, here, beside, node, renewed);
  }
}

/// What may be in some of the directions around a block; fetches what is needed of it next.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::ask(const RollingGrid& grid, BlockIndex block, std::uint32_t directions,
                            BlockIndex (&around)[kDirections]) const {
  const BlockAt at = BlockAt::from_key(grid.block(block).key);
  for (; directions != 0; directions &= directions - 1) {
    const int direction = std::countr_zero(directions);
    const BlockIndex index = grid.may_be(at.next(direction));
    around[direction] = index;
    if (index == kNoBlock) continue;
    __builtin_prefetch(&work_[index]);
    graph_.prefetch(index);
  }
}

/// Whether two blocks hold fragments of two components, or fresh ones: then edges between them may matter.
/// Not where one of them holds none.
template <SegmentationPolicy Policy>
bool Segmenter<Policy>::are_mixed(BlockIndex a, BlockIndex b) const {
  NodeIndex name = kNoNode;
  if (graph_.first(a) == kNoNode || graph_.first(b) == kNoNode) return false;
  for (const BlockIndex block : {a, b}) {
    for (NodeIndex node = graph_.first(block); node != kNoNode; node = graph_[node].next) {
      const NodeIndex its = graph_[node].name;
      if (its == kNoNode || (name != kNoNode && its != name)) return true;
      name = its;
    }
  }
  return false;
}

/// In which directions there is more than one component, and in which of these an edge may have come.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::survey(const RollingGrid& grid, const Here& here,
                               const BlockIndex (&around)[kDirections], Pairs& pairs) {
  BlockWork& own = work_[here.index];
  const Block& block = grid.block(here.index);
  const std::uint32_t directions = own.mixed & ~(1u << kHere);
  own.mixed = 0;
  for (std::uint32_t rest = directions; rest != 0; rest &= rest - 1) {
    const int direction = std::countr_zero(rest);
    const BlockIndex index = around[direction];
    if (index == kNoBlock || !grid.is_next(block, direction, index)) continue;
    const std::uint32_t bit = 1u << direction;
    BlockWork& other = work_[index];
    const bool mixed = are_mixed(here.index, index);
    if (mixed) {
      own.mixed |= bit;
      other.mixed |= 1u << (26 - direction);
      // One that is still to be looked at before the labelling tests the pair itself.
      if (other.queued == tag(cycle_)) {
        pairs.waiting |= bit;
        continue;
      }
    }
    // Where it was looked at first it left the pair to this one.
    const bool looked = other.cycle == own.cycle;
    const std::uint64_t its = looked ? other.looked & reach_.rim(26 - direction) : 0;
    if (its != 0) {
      pairs.looked |= bit;
      pairs.moved[direction] = its;
    }
    // Where nothing within reach of the border moved, nothing changes.
    if (!mixed ||
        (((here.fresh | here.moved) & reach_.rim(direction)) == 0 && !(looked && other.renewed) && its == 0))
      continue;
    pairs.open |= bit;
    pairs.moved[direction] = its;
  }
}

/// Edges between a fragment and those of other components in the block beside it.
template <SegmentationPolicy Policy>
void Segmenter<Policy>::look_from(const RollingGrid& grid, const Here& here, const Beside& beside,
                                  NodeIndex node, bool renewed) {
  const FragmentNode& from = graph_[node];
  if ((from.cells & reach_.rim(beside.direction)) == 0) return;
  const bool fresh = (from.cells & here.fresh) != 0;
  std::uint64_t open = 0;  // where only what moved can have made an edge
  std::uint64_t all = 0;
  for (NodeIndex other = graph_.first(beside.index); other != kNoNode; other = graph_[other].next) {
    const FragmentNode& to = graph_[other];
    if (from.name != kNoNode && from.name == to.name) continue;
    (fresh || (renewed && to.name == kNoNode) ? all : open) |= to.cells;
  }
  const std::uint64_t rim = reach_.rim(26 - beside.direction);
  all &= rim;
  open &= rim;
  if ((from.cells & here.moved & reach_.rim(beside.direction)) == 0 && (beside.moved & open) == 0) open = 0;
  if ((open | all) == 0) return;
  const std::uint64_t known = joined(beside, node);
  if ((open & ~known) != 0) search(grid, here, beside, node, open & ~known, false);
  if ((all & ~known) != 0) search(grid, here, beside, node, all & ~known, true);
}

}  // namespace sortie::mapping
