// SPDX-License-Identifier: BSD-3-Clause
// Stages of a labelling, one after the other, each in small steps: forget the last one, unite what touches,
// look whether components fell apart and have that checked, put nodes of a component together, count for
// every segment which component holds most of it, decide on ids, write; where nodes left meanwhile, look
// which segments left with them.
#include "mapping/segments/labelling.hpp"

#include <algorithm>

namespace sortie::mapping {
namespace {
constexpr std::uint16_t kNoComponent = 0xffff;
constexpr std::uint32_t kResetAtOnce = 16;  ///< nodes that a step forgets
constexpr std::uint32_t kAhead = 8;         ///< nodes whose blocks are fetched before they are needed
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
  apart_ = kNoNode;
  fallen_apart_ = false;
  disturbed_ = false;
  nameless_ = leaving_ = 0;
  making_ = {};
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
  while (used < units && stage_ != Stage::idle && apart_ == kNoNode) {
    const std::uint32_t before = at_;
    const std::uint32_t room = units - used;
    const Stage stage = stage_;
    const std::uint32_t end = run_stage(graph, blocks, room);
    used += stage == Stage::reset ? (end - before) / kResetAtOnce + 1 : end - before + 1;
  }
  return used;
}

/// At most `room` steps of the present stage, and on to the next one when it is done; gives where it came to.
std::uint32_t Labelling::run_stage(FragmentGraph& graph, std::span<const Block> blocks, std::uint32_t room) {
  if (stage_ == Stage::reset) nodes_ = graph.numbers();
  const auto upto = [this, room](std::uint32_t size) { return room < size - at_ ? at_ + room : size; };
  const std::uint32_t nodes = upto(nodes_);
  switch (stage_) {
    case Stage::idle:
      return at_;
    case Stage::reset: {
      const std::uint32_t end = room < (nodes_ - at_) / kResetAtOnce ? at_ + room * kResetAtOnce : nodes_;
      for (; at_ < end; ++at_) memory_.work[at_] = {static_cast<NodeIndex>(at_), 0, kNoNode};
      return end == nodes_ ? next(Stage::unite) : end;
    }
    case Stage::unite:
      for (; at_ < nodes; ++at_) {
        if (graph[static_cast<NodeIndex>(at_)].cells != 0) unite_around(graph, static_cast<NodeIndex>(at_));
      }
      return nodes == nodes_ ? next(Stage::survey) : nodes;
    case Stage::survey:
      for (; at_ < nodes; ++at_) {
        const FragmentNode& node = graph[static_cast<NodeIndex>(at_)];
        if (node.cells != 0 && node.name != kNoNode) survey(static_cast<NodeIndex>(at_), node.name);
      }
      return nodes == nodes_ ? next(fallen_apart_ ? Stage::repair : Stage::reset_slots) : nodes;
    case Stage::repair:
      while (at_ < nodes) {
        const auto node = static_cast<NodeIndex>(at_++);
        const NodeIndex name = graph[node].name;
        if (graph[node].cells == 0 || name == kNoNode || together(node, memory_.work[name].next)) continue;
        apart_ = node;
        return at_;
      }
      return nodes == nodes_ ? next(Stage::reset_slots) : nodes;
    case Stage::group:
      for (; at_ < nodes; ++at_) {
        const FragmentNode& node = graph[static_cast<NodeIndex>(at_)];
        const BlockIndex ahead = graph[static_cast<NodeIndex>(std::min(at_ + kAhead, nodes_ - 1))].block;
        if (ahead != kNoBlock) __builtin_prefetch(&blocks[ahead]);
        // Roots have smaller numbers and come first, so that a parent's parent is the root by now.
        memory_.work[at_].parent = memory_.work[memory_.work[at_].parent].parent;
        if (memory_.work[at_].parent == at_) memory_.work[at_].component = kNoComponent;
        if (node.cells != 0) group(node, blocks[node.block].key << 6 | lowest(node.cells));
      }
      if (nodes != nodes_) return nodes;
      vote_node_ = components_ > 0 ? memory_.components[0].first : kNoNode;
      return next(Stage::vote);
    case Stage::vote: {
      const std::uint32_t begin = at_;
      std::uint32_t steps = 0;
      for (; at_ < components_ && steps < room; ++steps) vote(graph);
      if (at_ == components_) next(Stage::close);
      return begin + steps;
    }
    case Stage::reset_slots:
    case Stage::close:
    case Stage::decide:
    case Stage::rename:
    case Stage::settle: {
      const std::uint32_t slots = upto(slot_numbers_);
      for (; at_ < slots; ++at_) visit_slot(static_cast<std::uint16_t>(at_));
      if (slots != slot_numbers_) return slots;
      if (stage_ == Stage::settle) {
        publish();
        return slots;
      }
      return next(stage_ == Stage::reset_slots ? Stage::group
                  : stage_ == Stage::close     ? Stage::decide
                  : stage_ == Stage::decide    ? Stage::rename
                                               : Stage::queue);
    }
    case Stage::queue: {
      const std::uint32_t components = upto(components_);
      for (; at_ < components; ++at_) queue(static_cast<std::uint16_t>(at_));
      return components == components_ ? next(Stage::name) : components;
    }
    case Stage::name:
      if (fresh_ == 0) return next(Stage::write);
      std::ranges::pop_heap(memory_.fresh.first(fresh_), later());
      name(memory_.fresh[--fresh_]);
      return at_;
    case Stage::write:
      for (; at_ < nodes; ++at_) write(graph[static_cast<NodeIndex>(at_)], static_cast<NodeIndex>(at_));
      if (nodes == nodes_ && disturbed_) return next(Stage::settle);
      if (nodes == nodes_) publish();
      return nodes;
  }
  return at_;
}

void Labelling::unite_around(const FragmentGraph& graph, NodeIndex node) {
  for (NodeIndex part = node; part != kNoNode; part = graph[part].extension) {
    for (const FragmentEdge& edge : graph[part].known()) unite(node, edge.to);
  }
}

/// Which root has most of the nodes of each component of before: the majority vote of Boyer and Moore, one
/// pass. Where no root has more than half, some root is as good.
void Labelling::survey(NodeIndex node, NodeIndex name) {
  const NodeIndex top = root(node);
  NodeWork& named = memory_.work[name];
  if (named.next == top) {
    ++named.component;
    return;
  }
  if (named.next != kNoNode) fallen_apart_ = true;
  if (named.component == 0) {
    named.next = top;
    named.component = 1;
  } else {
    --named.component;
  }
}

/// One slot in a stage that goes over all of them.
void Labelling::visit_slot(std::uint16_t index) {
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
  } else if (slot.most > 0 && (memory_.components[slot.owner].slot == index) == (stage_ == Stage::settle)) {
    if (stage_ == Stage::rename) {
      event(SegmentChange::renamed, slot.id, memory_.slots[memory_.components[slot.owner].slot].id);
      ++making_.renamed;
      ++leaving_;
    } else if (slot.voxels[1 - shown_] == 0) {
      // It was to stay, or was born: then all of its nodes left. The next labelling forgets it.
      go(slot);
    }
  }
}

void Labelling::group(const FragmentNode& node, std::uint64_t key) {
  NodeWork& own = memory_.work[at_];
  std::uint16_t& component = memory_.work[own.parent].component;
  if (component == kNoComponent) {
    component = static_cast<std::uint16_t>(components_++);
    memory_.components[component] = {key, 0, kNoNode, kNoLabel, kNoLabel};
  }
  SegmentComponent& c = memory_.components[component];
  c.key = std::min(c.key, key);
  c.voxels += node.voxels;
  own.next = c.first;
  c.first = static_cast<NodeIndex>(at_);
}

void Labelling::write(FragmentNode& node, NodeIndex index) {
  if (node.cells == 0) return;
  node.name = memory_.work[index].parent;
  const std::uint16_t slot = memory_.components[memory_.work[node.name].component].slot;
  node.label[1 - shown_] = slot;
  if (slot != kNoLabel) memory_.slots[slot].voxels[1 - shown_] += node.voxels;
}

void Labelling::leaving(const FragmentGraph& graph, BlockIndex block) {
  if (!running()) return;
  disturbed_ = true;
  if (apart_ != kNoNode && graph[apart_].block == block) apart_ = kNoNode;
}

void Labelling::finish_names(FragmentGraph& graph) const {
  if (stage_ != Stage::write) return;
  for (std::uint32_t i = at_; i < nodes_; ++i) {
    FragmentNode& node = graph[static_cast<NodeIndex>(i)];
    if (node.cells != 0) node.name = memory_.work[i].parent;
  }
}

void Labelling::publish() {
  shown_ = 1 - shown_;
  shown_events_ = events_;
  shown_components_ = components_;
  shown_nameless_ = nameless_;
  next_id_ += static_cast<SegmentId>(making_.born);
  ++counts_.labellings;
  rt::add_fields(making_, counts_);
  next(Stage::idle);
}

void Labelling::event(SegmentChange change, SegmentId id, SegmentId other) {
  if (events_ == half()) {
    ++making_.events_lost;
    return;
  }
  memory_.events[(1 - shown_) * half() + events_++] = {change, id, other};
}

}  // namespace sortie::mapping
