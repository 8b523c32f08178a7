// SPDX-License-Identifier: BSD-3-Clause
// Peels a graph: the vertex with the fewest neighbours goes first. What is left last is its densest core.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/bit_graph.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/arena.hpp"

namespace sortie::mapping {

/// Core numbers and the order of degeneracy (V. Batagelj, M. Zaversnik 2003), vertex by vertex. A vertex of
/// core number c has at least c neighbours among those that come behind it or have that core number, too; a
/// clique of n vertices lies within those of core number n - 1 or more. The same graph gives the same order,
/// whatever the budgets. Cost: a unit a word of 64 vertices and one an edge. Memory: 8 bytes a vertex. No
/// heap.
class CoreOrder {
 public:
  /// Room for `most` vertices, at most 65,535.
  CoreOrder(std::uint32_t most, rt::Arena& arena);

  /// Begins with the subgraph of `members`, a bit each; both outlive the work. Room is the caller's business.
  void begin(const BitGraph& graph, std::span<const BitGraph::Word> members);
  /// Goes on for at most `units` and a vertex, takes what it used off. True: the order is whole.
  bool run(std::uint64_t& units);

  /// Members, the first to be peeled first: core numbers never fall along it.
  std::span<const std::uint16_t> order() const { return order_.first(count_); }
  std::uint16_t core(std::uint32_t vertex) const { return degree_[vertex]; }
  /// Where a member stands in the order.
  std::uint16_t position(std::uint32_t vertex) const { return position_[vertex]; }

 private:
  std::uint16_t neighbours(std::uint32_t vertex) const;
  void sort();
  std::uint32_t peel(std::uint32_t vertex);

  BitGraph graph_;
  std::span<const BitGraph::Word> members_;
  std::uint32_t count_{};
  std::uint32_t counted_{};  ///< vertices whose degree is known
  std::uint32_t peeled_{};
  bool sorted_{};
  std::span<std::uint16_t> order_;
  std::span<std::uint16_t> position_;
  std::span<std::uint16_t> degree_;  ///< among those that are not peeled; then the core number
  std::span<std::uint16_t> first_;   ///< of each degree, in order_
  UnitCredit credit_;
};

}  // namespace sortie::mapping
