// SPDX-License-Identifier: BSD-3-Clause
// Segments and fragments to bytes and back.
#include <algorithm>

#include "mapping/segments/fragment_graph.hpp"
#include "mapping/segments/labelling.hpp"

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kSegmentsFormat = 4;
constexpr std::uint8_t kUnseen = 0xff;  ///< marks a node that no list has held yet
}  // namespace

void Labelling::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "segments")
      .fixed(min_voxels_, memory_)
      .scratch(stage_, at_, tick_, nodes_, vote_node_, apart_, fallen_apart_, components_, fresh_, slot_hand_,
               events_, nameless_, leaving_, disturbed_, making_)
      .by_hand(slot_numbers_, shown_, shown_events_)
      .state(shown_components_, shown_nameless_, next_id_, counts_);
  archive.expect(kSegmentsFormat, "the segments have another format version");
  archive.bounded(slot_numbers_, memory_.slots.size());
  archive.bounded(shown_, 1);
  archive.bounded(shown_events_, half());
  for (SegmentSlot& slot : memory_.slots.first(slot_numbers_)) {
    archive.value(slot.id);
    archive.value(slot.first_tick);
    archive.value(slot.voxels);
  }
  for (SegmentEvent& event : memory_.events.subspan(shown_ * half(), shown_events_)) {
    archive.value(event);
    if (event.change > SegmentChange::gone) archive.fail(Status::malformed, "no event of a segment");
  }
  if (!archive.is_reading()) return;
  stage_ = Stage::idle;
  apart_ = kNoNode;
  events_ = 0;
}

void FragmentGraph::archive(rt::Archive& archive, std::span<const Block> blocks, unsigned shown,
                            std::uint32_t slots) {
  rt::Members(archive, *this, "fragments")
      .fixed(nodes_, first_)
      .by_hand(numbers_, in_use_, free_, waiting_)
      .scratch(last_waiting_, held_)
      .state(most_in_use_, refused_);
  archive.bounded(numbers_, nodes_.size());
  archive.value(free_);
  archive.value(waiting_);
  if (archive.is_reading()) std::fill(first_.begin(), first_.end(), kNoNode);
  for (std::size_t i = 0; i < blocks.size(); ++i) archive.value(first_[i]);
  for (FragmentNode& node : nodes_.first(numbers_)) {
    if (archive.is_reading()) node = FragmentNode{};
    archive.value(node.block);
    archive.value(node.next);
    if (node.block == kNoBlock) continue;  // a free one
    archive.value(node.cells);
    archive.value(node.label[shown]);
    archive.value(node.extension);
    archive.value(node.backward_set);
    archive.value(node.name);
    std::uint32_t edges = node.edges;
    archive.bounded(edges, FragmentNode::kEdges);
    node.edges = static_cast<std::uint8_t>(edges);
    for (unsigned i = 0; i < node.edges; ++i) {
      archive.value(node.edge[i].to);
      archive.value(node.edge[i].made);
    }
  }
  if (!archive.is_reading()) return;
  if (archive.status() != Status::ok || !is_graph(blocks, shown, slots)) {
    archive.fail(Status::malformed, "fragments that are not of this map");
    numbers_ = in_use_ = 0;
    free_ = waiting_ = kNoNode;
    std::fill(first_.begin(), first_.end(), kNoNode);
  }
  // A labelling that was under way begins anew.
  hold(false);
}

/// Takes a node off those that no list has held yet; false when there is no such node.
bool FragmentGraph::claim(NodeIndex node, bool in_use) {
  if (node >= numbers_ || nodes_[node].voxels != kUnseen || (!in_use && nodes_[node].cells != 0))
    return false;
  nodes_[node].voxels = static_cast<std::uint8_t>(bits_in(nodes_[node].cells));
  if (in_use) ++in_use_;
  return true;
}

/// Whether every node is in one list and only once, and fits the blocks and the nodes that it names. Counts
/// the nodes.
bool FragmentGraph::is_graph(std::span<const Block> blocks, unsigned shown, std::uint32_t slots) {
  for (FragmentNode& node : nodes_.first(numbers_)) node.voxels = kUnseen;
  in_use_ = 0;
  std::uint32_t free = 0;
  last_waiting_ = kNoNode;
  for (NodeIndex node = free_; node != kNoNode; node = nodes_[node].next, ++free) {
    if (!claim(node, false)) return false;
  }
  for (NodeIndex node = waiting_; node != kNoNode; node = nodes_[node].next, ++free) {
    if (!claim(node, false)) return false;
    last_waiting_ = node;
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    std::uint64_t seen = 0;
    for (NodeIndex node = first_[i]; node != kNoNode; node = nodes_[node].next) {
      if (!claim(node, true)) return false;
      const FragmentNode& n = nodes_[node];
      if (n.cells == 0 || n.block != i || !blocks[i].in_use() || (n.cells & ~blocks[i].active) != 0 ||
          (n.cells & seen) != 0 || (n.label[shown] != kNoLabel && n.label[shown] >= slots) ||
          (n.name != kNoNode && n.name >= numbers_) || n.backward_set >> FragmentNode::kForward != 0)
        return false;
      seen |= n.cells;
      for (NodeIndex part = n.extension; part != kNoNode; part = nodes_[part].extension) {
        if (!claim(part, true) || nodes_[part].cells != 0 || nodes_[part].block != i) return false;
      }
    }
  }
  if (in_use_ + free != numbers_) return false;
  for (const FragmentNode& node : nodes_.first(numbers_)) {
    if (!are_edges(node, blocks)) return false;
  }
  return true;
}

/// Whether a node's edges lead to fragments where the directions say, between voxels that are there.
bool FragmentGraph::are_edges(const FragmentNode& node, std::span<const Block> blocks) const {
  if (node.edges == 0) return true;
  if (node.block >= blocks.size()) return false;
  const Block& own = blocks[node.block];
  for (const FragmentEdge& edge : node.known()) {
    if (edge.direction() >= kDirections || edge.to >= numbers_) return false;
    const FragmentNode& to = nodes_[edge.to];
    if (to.cells == 0) return false;
    const Block& its = blocks[to.block];
    if (its.key != own.key + kKeySteps.step[edge.direction()] || (own.active >> edge.own() & 1) == 0 ||
        (its.active >> edge.its() & 1) == 0)
      return false;
  }
  return true;
}

}  // namespace sortie::mapping
