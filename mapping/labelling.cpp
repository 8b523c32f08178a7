// SPDX-License-Identifier: BSD-3-Clause
// Stages of a labelling, one after the other, each in small steps: forget the last one, unite what touches,
// put nodes of a component together, count for every segment which component holds most of it, decide on ids,
// write.
#include "mapping/labelling.hpp"

#include <algorithm>

namespace sortie::mapping {
namespace {
constexpr std::uint16_t kNoComponent = 0xffff;
constexpr std::uint32_t kResetAtOnce = 16;  ///< nodes that a step forgets
}  // namespace

Labelling::Labelling(std::uint32_t min_voxels, const LabellingMemory& memory)
    : min_voxels_(min_voxels), memory_(memory) {
  memory_.slots = memory_.slots.first(std::min<std::size_t>(memory_.slots.size(), kNoLabel - 1));
}

void Labelling::start(std::uint32_t tick) {
  tick_ = tick;
  components_ = 0;
  fresh_ = 0;
  events_ = 0;
  slot_hand_ = 0;
  nodes_ = 0xffffffffu;
  next(Stage::reset);
}

/// The representative of a node's component so far; halves the way there.
NodeIndex Labelling::root(NodeIndex node) {
  NodeWork* const work = memory_.work.data();
  while (work[node].parent != node) {
    work[node].parent = work[work[node].parent].parent;
    node = work[node].parent;
  }
  return node;
}

void Labelling::unite(NodeIndex a, NodeIndex b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  // The smaller number is the root: no ranks to keep, and neighbours in space are neighbours in the pool.
  (a < b ? memory_.work[b].parent : memory_.work[a].parent) = std::min(a, b);
}

std::uint32_t Labelling::run(FragmentGraph& graph, std::span<const Block> blocks, std::uint32_t units) {
  std::uint32_t used = 0;
  for (; used < units && stage_ != Stage::idle; ++used) step(graph, blocks);
  return used;
}

void Labelling::step(FragmentGraph& graph, std::span<const Block> blocks) {
  const std::uint32_t nodes = std::min(nodes_, graph.numbers());
  switch (stage_) {
    case Stage::idle:
      return;
    case Stage::reset: {
      nodes_ = nodes;
      const std::uint32_t end = std::min(at_ + kResetAtOnce, nodes);
      for (; at_ < end; ++at_) memory_.work[at_] = {static_cast<NodeIndex>(at_), kNoComponent, kNoNode};
      if (at_ == nodes) next(Stage::unite);
      return;
    }
    case Stage::unite: {
      if (at_ == nodes) return next(Stage::reset_slots);
      const auto node = static_cast<NodeIndex>(at_++);
      if (graph[node].cells == 0) return;
      for (NodeIndex part = node; part != kNoNode; part = graph[part].extension) {
        for (unsigned set = graph[part].forward_set; set != 0; set &= set - 1)
          unite(node, graph[part].forward[std::countr_zero(set)]);
      }
      return;
    }
    case Stage::group: {
      if (at_ == nodes) {
        vote_node_ = components_ > 0 ? memory_.components[0].first : kNoNode;
        return next(Stage::vote);
      }
      const auto node = static_cast<NodeIndex>(at_++);
      if (graph[node].cells != 0) group(graph, blocks[graph[node].block].key, node);
      return;
    }
    case Stage::vote:
      if (at_ == components_) return next(Stage::close);
      vote(graph, static_cast<std::uint16_t>(at_));
      return;
    case Stage::reset_slots:
    case Stage::close:
    case Stage::decide:
    case Stage::rename:
      if (at_ < slot_numbers_) return step_slot();
      return next(stage_ == Stage::reset_slots ? Stage::group
                  : stage_ == Stage::close     ? Stage::decide
                  : stage_ == Stage::decide    ? Stage::rename
                                               : Stage::queue);
    case Stage::queue:
      if (at_ == components_) return next(Stage::name);
      queue(static_cast<std::uint16_t>(at_++));
      return;
    case Stage::name:
      if (fresh_ == 0) return next(Stage::write);
      std::pop_heap(memory_.fresh.begin(), memory_.fresh.begin() + fresh_, later());
      name(memory_.fresh[--fresh_]);
      return;
    case Stage::write:
      if (at_ == nodes) return publish();
      write(graph, static_cast<NodeIndex>(at_++));
      return;
  }
}

/// One slot in a stage that goes over all of them.
void Labelling::step_slot() {
  const auto index = static_cast<std::uint16_t>(at_++);
  SegmentSlot& slot = memory_.slots[index];
  if (stage_ == Stage::reset_slots) {
    if (slot.voxels[shown_] == 0) slot.id = kNoSegment;
    slot.voxels[1 - shown_] = 0;
    slot.most = slot.here = 0;
    slot.owner = slot.looked = kNoComponent;
    return;
  }
  if (slot.id == kNoSegment) return;
  if (stage_ == Stage::close) {
    close_vote(slot);
  } else if (stage_ == Stage::decide) {
    decide(index);
  } else if (slot.most > 0 && memory_.components[slot.owner].slot != index) {
    event(SegmentChange::renamed, slot.id, memory_.slots[memory_.components[slot.owner].slot].id);
    ++counts_.renamed;
  }
}

void Labelling::group(FragmentGraph& graph, std::uint64_t block_key, NodeIndex node) {
  const NodeIndex top = root(node);
  std::uint16_t& component = memory_.work[top].component;
  const std::uint64_t key = block_key << 6 | lowest(graph[node].cells);
  if (component == kNoComponent) {
    component = static_cast<std::uint16_t>(components_++);
    memory_.components[component] = {key, 0, kNoNode, kNoLabel, kNoLabel};
  }
  SegmentComponent& c = memory_.components[component];
  c.key = std::min(c.key, key);
  c.voxels += graph[node].voxels;
  memory_.work[node].next = c.first;
  c.first = node;
}

/// The next node of a component gives its voxels to the segment that it was of.
void Labelling::vote(FragmentGraph& graph, std::uint16_t component) {
  const NodeIndex node = vote_node_;
  vote_node_ = memory_.work[node].next;
  if (vote_node_ == kNoNode && ++at_ < components_) vote_node_ = memory_.components[at_].first;
  const std::uint16_t label = graph[node].label[shown_];
  if (graph[node].cells == 0 || label == kNoLabel) return;
  SegmentComponent& c = memory_.components[component];
  SegmentSlot& slot = memory_.slots[label];
  if (c.cut_from == kNoLabel || slot.id < memory_.slots[c.cut_from].id) c.cut_from = label;
  if (slot.looked != component) {
    close_vote(slot);
    slot.looked = component;
    slot.here = 0;
  }
  slot.here += graph[node].voxels;
}

void Labelling::close_vote(SegmentSlot& slot) {
  if (slot.here == 0) return;
  const bool more = slot.here > slot.most;
  const bool tie =
      slot.here == slot.most && memory_.components[slot.looked].key < memory_.components[slot.owner].key;
  if (more || tie) {
    slot.most = slot.here;
    slot.owner = slot.looked;
  }
  slot.here = 0;
}

/// Of the segments that stay with a component the oldest one names it.
void Labelling::decide(std::uint16_t index) {
  const SegmentSlot& slot = memory_.slots[index];
  if (slot.most == 0) {
    ++counts_.gone;
    return event(SegmentChange::gone, slot.id, kNoSegment);
  }
  std::uint16_t& named = memory_.components[slot.owner].slot;
  if (named == kNoLabel || slot.id < memory_.slots[named].id) named = index;
}

/// Components that need a new id line up by key.
void Labelling::queue(std::uint16_t component) {
  const SegmentComponent& c = memory_.components[component];
  if (c.slot != kNoLabel || c.voxels < min_voxels_) return;
  memory_.fresh[fresh_++] = component;
  std::push_heap(memory_.fresh.begin(), memory_.fresh.begin() + fresh_, later());
}

void Labelling::name(std::uint16_t component) {
  const auto size = static_cast<std::uint32_t>(memory_.slots.size());
  while (slot_hand_ < slot_numbers_ && memory_.slots[slot_hand_].id != kNoSegment) ++slot_hand_;
  if (slot_hand_ == slot_numbers_) {
    if (slot_numbers_ == size) {
      ++counts_.slots_full;
      return;
    }
    ++slot_numbers_;
  }
  SegmentComponent& c = memory_.components[component];
  c.slot = static_cast<std::uint16_t>(slot_hand_);
  memory_.slots[slot_hand_] = SegmentSlot{};
  memory_.slots[slot_hand_].id = next_id_++;
  memory_.slots[slot_hand_].first_tick = tick_;
  const bool cut = c.cut_from != kNoLabel;
  ++counts_.born;
  if (cut) ++counts_.cut;
  event(SegmentChange::born, memory_.slots[slot_hand_].id, cut ? memory_.slots[c.cut_from].id : kNoSegment);
}

void Labelling::write(FragmentGraph& graph, NodeIndex node) {
  FragmentNode& n = graph[node];
  if (n.cells == 0) return;
  const std::uint16_t slot = memory_.components[memory_.work[root(node)].component].slot;
  n.label[1 - shown_] = slot;
  if (slot != kNoLabel) memory_.slots[slot].voxels[1 - shown_] += n.voxels;
}

void Labelling::publish() {
  shown_ = 1 - shown_;
  shown_events_ = events_;
  shown_components_ = components_;
  ++counts_.labellings;
  next(Stage::idle);
}

void Labelling::event(SegmentChange change, SegmentId id, SegmentId other) {
  if (events_ == half()) {
    ++counts_.events_lost;
    return;
  }
  memory_.events[(1 - shown_) * half() + events_++] = {change, id, other};
}

}  // namespace sortie::mapping
