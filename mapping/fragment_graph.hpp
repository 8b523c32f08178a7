// SPDX-License-Identifier: BSD-3-Clause
// Fragments: the connected parts of single blocks, and which of them touch across blocks. A few thousand of
// them stand for a hundred thousand voxels.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/block.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

using NodeIndex = std::uint16_t;
inline constexpr NodeIndex kNoNode = 0xffff;
inline constexpr std::uint16_t kNoLabel = 0xffff;

/// One fragment. An edge is kept by the fragment whose neighbour lies in one of the 13 forward directions (14
/// to 26). Two edges in one direction need an extension: a fragment without cells that is only more room. 80
/// bytes.
struct FragmentNode {
  static constexpr int kForward = 13;
  std::uint64_t cells{};  ///< empty for an extension and for a free one
  BlockIndex block{kNoBlock};
  NodeIndex next{kNoNode};                     ///< of the same block; or in the list of free ones
  std::uint16_t label[2]{kNoLabel, kNoLabel};  ///< one is shown, the other one in the making
  std::uint16_t forward_set{};                 ///< bit n: forward[n] holds the neighbour in direction 14 + n
  NodeIndex extension{kNoNode};
  NodeIndex forward[kForward]{};
  std::uint16_t witness[kForward]{};  ///< the two voxels that make the edge: own cell, its cell << 6
  std::uint16_t backward_set{};       ///< bit n: may be a forward neighbour of the block in direction 12 - n
  NodeIndex name{
      kNoNode};  ///< of its component by the newest labelling: a number that its nodes share; or it is fresh
  std::uint8_t voxels{};
};
static_assert(sizeof(FragmentNode) == 80 || sizeof(FragmentNode) == 76);

/// The pool of fragments and the lists of them, one a block.
class FragmentGraph {
 public:
  /// `nodes`: at most 65,534; `first`: one a block.
  FragmentGraph(std::span<FragmentNode> nodes, std::span<NodeIndex> first);

  /// A node of a block, appended to `list` of it by the caller; kNoNode when there is none left (counted).
  NodeIndex take(BlockIndex block, std::uint64_t cells);
  /// Gives all nodes of a block back. Edges of other blocks to them must be gone, or go next (disconnect()).
  void give(BlockIndex block);
  /// Drops all forward edges of a block's nodes.
  void drop_forward(BlockIndex block);
  /// Drops the edges that the nodes of `from` keep in a forward direction.
  void disconnect(BlockIndex from, int direction);
  /// Joins node `from` with a node in a forward direction. When no room is left the edge is lost and counted.
  void connect(NodeIndex from, int direction, NodeIndex to, std::uint16_t witness);
  /// Node of a block that holds a cell, or kNoNode.
  NodeIndex holder(BlockIndex block, unsigned cell) const;

  /// Fragments, their shown labels and edges, and the order in which free ones are taken, to bytes and back.
  /// What does not fit the blocks is malformed and leaves no fragments.
  void archive(rt::Archive& archive, std::span<const Block> blocks, unsigned shown, std::uint32_t slots);

  NodeIndex first(BlockIndex block) const { return first_[block]; }
  void set_first(BlockIndex block, NodeIndex node) { first_[block] = node; }
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
