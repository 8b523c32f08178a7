// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/segments/fragment_graph.hpp"

#include <algorithm>

namespace sortie::mapping {

FragmentGraph::FragmentGraph(std::span<FragmentNode> nodes, std::span<NodeIndex> first)
    : nodes_(nodes.first(std::min<std::size_t>(nodes.size(), kNoNode - 1))), first_(first) {
  std::fill(first_.begin(), first_.end(), kNoNode);
}

NodeIndex FragmentGraph::take(BlockIndex block, std::uint64_t cells) {
  NodeIndex node = free_;
  if (node != kNoNode) {
    free_ = nodes_[node].next;
  } else if (numbers_ < nodes_.size()) {
    node = static_cast<NodeIndex>(numbers_++);
  } else {
    ++refused_;
    return kNoNode;
  }
  nodes_[node] = FragmentNode{};
  nodes_[node].block = block;
  nodes_[node].cells = cells;
  nodes_[node].voxels = static_cast<std::uint8_t>(bits_in(cells));
  most_in_use_ = std::max(most_in_use_, ++in_use_);
  return node;
}

void FragmentGraph::give_one(NodeIndex node) {
  nodes_[node].cells = 0;
  nodes_[node].block = kNoBlock;
  nodes_[node].edges = 0;
  --in_use_;
  if (!held_) {
    nodes_[node].next = free_;
    free_ = node;
    return;
  }
  nodes_[node].next = waiting_;
  waiting_ = node;
  if (last_waiting_ == kNoNode) last_waiting_ = node;
}

void FragmentGraph::give(NodeIndex node) {
  while (node != kNoNode) {
    const NodeIndex extension = nodes_[node].extension;
    nodes_[node].extension = kNoNode;
    give_one(node);
    node = extension;
  }
}

void FragmentGraph::give_all(BlockIndex block) {
  for (NodeIndex node = first_[block]; node != kNoNode;) {
    const NodeIndex next = nodes_[node].next;
    give(node);
    node = next;
  }
  first_[block] = kNoNode;
}

void FragmentGraph::disconnect(BlockIndex from, int direction, NodeIndex to) {
  for (NodeIndex node = first_[from]; node != kNoNode; node = nodes_[node].next) {
    for (NodeIndex part = node; part != kNoNode; part = nodes_[part].extension) {
      for (unsigned i = nodes_[part].edges; i-- > 0;) {
        const FragmentEdge& edge = nodes_[part].edge[i];
        if (edge.direction() == direction && (to == kNoNode || edge.to == to)) nodes_[part].take_out(i);
      }
    }
  }
}

bool FragmentGraph::connect(NodeIndex from, const FragmentEdge& edge) {
  NodeIndex part = from;
  while (nodes_[part].edges == FragmentNode::kEdges) {
    if (nodes_[part].extension == kNoNode) {
      const NodeIndex extension = take(nodes_[from].block, 0);
      if (extension == kNoNode) return false;
      nodes_[part].extension = extension;
    }
    part = nodes_[part].extension;
  }
  nodes_[part].edge[nodes_[part].edges++] = edge;
  FragmentNode& to = nodes_[edge.to];
  to.backward_set = static_cast<std::uint16_t>(to.backward_set | 1u << (edge.direction() - 14));
  return true;
}

NodeIndex FragmentGraph::holder(BlockIndex block, unsigned cell) const {
  NodeIndex node = first_[block];
  while (node != kNoNode && (nodes_[node].cells & cell_bit(cell)) == 0) node = nodes_[node].next;
  return node;
}

void FragmentGraph::hold(bool held) {
  held_ = held;
  if (held || waiting_ == kNoNode) return;
  nodes_[last_waiting_].next = free_;
  free_ = waiting_;
  waiting_ = kNoNode;
  last_waiting_ = kNoNode;
}

}  // namespace sortie::mapping
