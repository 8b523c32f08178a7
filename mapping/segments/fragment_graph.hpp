// SPDX-License-Identifier: BSD-3-Clause
// Fragments: the connected parts of single blocks, and which of them touch across blocks. A few thousand of
// them stand for a hundred thousand voxels.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/block.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

using NodeIndex = std::uint16_t;
inline constexpr NodeIndex kNoNode = 0xffff;
inline constexpr std::uint16_t kNoLabel = 0xffff;

/// An edge to a fragment of the block in one of the 13 forward directions (14 to 26), and the two voxels that
/// make it. 4 bytes.
struct FragmentEdge {
  NodeIndex to{};
  std::uint16_t made{};  ///< direction - 14, own cell << 4, its cell << 10

  static constexpr FragmentEdge of(NodeIndex to, int direction, unsigned own, unsigned its) {
    return {to, static_cast<std::uint16_t>(static_cast<unsigned>(direction - 14) | own << 4 | its << 10)};
  }
  constexpr int direction() const { return 14 + (made & 15); }
  constexpr unsigned own() const { return made >> 4 & 63u; }
  constexpr unsigned its() const { return made >> 10; }
};

/// One fragment. An edge is kept by the fragment whose neighbour lies in a forward direction. More edges than
/// fit need an extension: a fragment without cells that is only more room. 48 bytes.
struct FragmentNode {
  static constexpr unsigned kEdges = 6;
  static constexpr int kForward = 13;
  std::uint64_t cells{};  ///< empty for an extension and for a free one
  BlockIndex block{kNoBlock};
  NodeIndex next{kNoNode};  ///< of the same block; or in the list of free ones
  NodeIndex extension{kNoNode};
  NodeIndex name{kNoNode};  ///< a number that its component's nodes share since a labelling; or it is fresh
  std::uint16_t label[2]{kNoLabel, kNoLabel};  ///< one is shown, the other one in the making
  std::uint16_t backward_set{};  ///< bit n: may be a forward neighbour of the block in direction 12 - n
  std::uint8_t voxels{};
  std::uint8_t edges{};
  FragmentEdge edge[kEdges]{};

  /// Edges of this one alone, without its extensions.
  std::span<const FragmentEdge> known() const { return {edge, edges}; }
  /// Takes an edge out; the last one moves to its place.
  void take_out(unsigned i) { edge[i] = edge[--edges]; }
};
static_assert(sizeof(FragmentNode) == 48);

/// The pool of fragments and the lists of them, one a block.
class FragmentGraph {
 public:
  /// `nodes`: at most 65,534; `first`: one a block.
  FragmentGraph(std::span<FragmentNode> nodes, std::span<NodeIndex> first);

  /// A node of a block, which the caller puts into the block's list; kNoNode when there is none left
  /// (counted).
  NodeIndex take(BlockIndex block, std::uint64_t cells);
  /// Gives all nodes of a block back. Edges of other blocks to them must be gone, or go next (disconnect()).
  void give_all(BlockIndex block);
  /// Gives one node back that its block no longer lists.
  void give(NodeIndex node);
  /// Drops the edges that the nodes of `from` keep in a forward direction: all, or those to node `to` alone.
  void disconnect(BlockIndex from, int direction, NodeIndex to = kNoNode);
  /// Adds an edge to a node. False when no room is left: it is lost and counted.
  [[nodiscard]] bool connect(NodeIndex from, const FragmentEdge& edge);
  /// Node of a block that holds a cell, or kNoNode.
  NodeIndex holder(BlockIndex block, unsigned cell) const;

  /// Fragments, their shown labels and edges, and the order in which free ones are taken, to bytes and back.
  /// What does not fit the blocks is malformed and leaves no fragments.
  void archive(rt::Archive& archive, std::span<const Block> blocks, unsigned shown, std::uint32_t slots);

  NodeIndex first(BlockIndex block) const { return first_[block]; }
  /// Puts a node into a block's list, behind `last` or, where that is kNoNode, first; kNoNode ends the list.
  void link(BlockIndex block, NodeIndex last, NodeIndex node) {
    (last == kNoNode ? first_[block] : nodes_[last].next) = node;
  }
  /// Fetches the list of a block; the first node of it, once the list is there.
  void prefetch(BlockIndex block) const { __builtin_prefetch(&first_[block]); }
  void prefetch_nodes(BlockIndex block) const {
    if (first_[block] != kNoNode) __builtin_prefetch(&nodes_[first_[block]]);
  }
  FragmentNode& operator[](NodeIndex node) { return nodes_[node]; }
  const FragmentNode& operator[](NodeIndex node) const { return nodes_[node]; }
  /// Nodes are numbered 0 .. numbers() - 1, free ones and extensions among them.
  std::uint32_t numbers() const { return numbers_; }
  std::uint32_t in_use() const { return in_use_; }
  std::uint32_t most_in_use() const { return most_in_use_; }
  std::uint64_t refused() const { return refused_; }
  /// Nodes that can be taken; while held, those that were given back meanwhile are counted too early.
  std::uint32_t room() const { return static_cast<std::uint32_t>(nodes_.size()) - in_use_; }

  /// While held, nodes that are given back are not handed out again: somebody is walking over them.
  void hold(bool held);

 private:
  void give_one(NodeIndex node);
  bool claim(NodeIndex node, bool in_use);
  bool is_graph(std::span<const Block> blocks, unsigned shown, std::uint32_t slots);
  bool are_edges(const FragmentNode& node, std::span<const Block> blocks) const;

  std::span<FragmentNode> nodes_;
  std::span<NodeIndex> first_;
  NodeIndex free_{kNoNode};
  NodeIndex waiting_{kNoNode};  ///< given back while held
  NodeIndex last_waiting_{kNoNode};
  bool held_{};
  std::uint32_t numbers_{};
  std::uint32_t in_use_{};
  std::uint32_t most_in_use_{};
  std::uint64_t refused_{};
};

}  // namespace sortie::mapping
