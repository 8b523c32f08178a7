// SPDX-License-Identifier: BSD-3-Clause
// The largest set of correspondences that are consistent two by two: the maximum clique of their graph, as
// far as a budget goes.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/core_order.hpp"

namespace sortie::mapping {

/// Room of a search.
struct ConsistentSetRoom {
  std::uint32_t vertices{1024};
  std::uint32_t around{1024};  ///< neighbours of one vertex that come behind it in the core order
  std::uint32_t size{128};     ///< of a set
};

/// Work of a search.
struct ConsistentSetCounts {
  std::uint64_t starts{};  ///< of sets that were grown greedily
  std::uint64_t opened{};  ///< vertices whose neighbours were searched whole
  std::uint64_t nodes{};   ///< of the branch and bound
  SORTIE_FIELDS(starts, opened, nodes)
};

/// An answer early, the best one late. Peels the graph (CoreOrder); grows a set from each vertex, densest
/// core first, always by the vertex that was peeled last; then branch and bound over each vertex's neighbours
/// that come behind it in the core order, with a bound by colours (E. Tomita; P. San Segundo et al., BBMC,
/// 2011: rows of bits). What it does depends on the graph alone; a budget says how far it comes, so more
/// units never give a smaller set. proved(): it is done, and there is no larger one. Cost: a unit a word of
/// 64 vertices that is looked at; never beyond a budget by more than one step, at most `around` rows. Memory:
/// the square of `around` in bits and `around` bits for each of `size` levels, twice. No heap.
class ConsistentSet {
 public:
  ConsistentSet(const ConsistentSetRoom& room, rt::Arena& arena);

  /// Begins with the subgraph of `members`, for a set of at least `least`. Both outlive the work. A graph,
  /// or a set, that there is no room for: none is found, and that is not proved.
  void begin(const BitGraph& graph, std::span<const BitGraph::Word> members, std::uint32_t least);
  /// Goes on for at most `units` and a step, takes what it used off. True: it is done.
  bool run(std::uint64_t& units);

  /// The largest set so far, vertices by number; empty as long as none of `least` was found.
  std::span<const std::uint16_t> found() const { return best_.first(best_size_); }
  bool proved() const { return step_ == Step::done && !cut_ && !is_full(); }
  const ConsistentSetCounts& counts() const { return counts_; }

 private:
  using Word = BitGraph::Word;
  enum class Step : std::uint8_t { done, peel, grow, open, search };

  std::uint32_t wanted() const { return best_size_ < least_ ? least_ : best_size_ + 1; }
  std::span<Word> left(std::uint32_t level) { return left_.subspan(std::size_t{level} * words_, words_); }
  std::span<Word> branches(std::uint32_t level) {
    return branches_.subspan(std::size_t{level} * words_, words_);
  }
  std::span<Word> inner(std::uint32_t i) { return inner_.subspan(std::size_t{i} * words_, words_); }
  bool is_over(std::uint32_t vertex) const { return order_.core(vertex) + 1u < wanted(); }
  /// There is no room for a larger set, should there be one.
  bool is_full() const { return best_size_ == best_.size(); }
  bool grow(std::uint64_t& units);
  bool open(std::uint64_t& units);
  bool search(std::uint64_t& units);
  void colour(std::uint32_t level);
  void keep();

  CoreOrder order_;
  BitGraph graph_;
  std::uint32_t least_{};
  std::uint32_t words_{};  ///< of the neighbours that are searched
  std::uint32_t at_{};     ///< in the core order, from its end
  std::uint32_t level_{};
  bool coloured_{};
  bool listed_{};  ///< the vertex that is opened is paid for
  bool cut_{};     ///< something was left out for want of room
  Step step_{Step::done};
  std::uint32_t size_{};  ///< of the set in hand
  std::uint32_t best_size_{};
  std::span<std::uint16_t> hand_;
  std::span<std::uint16_t> best_;
  std::span<std::uint16_t> around_;  ///< vertices of the search, those that were peeled last first
  std::span<std::uint16_t> index_;   ///< of each vertex in around_
  std::span<Word> members_;
  std::span<Word> pool_;      ///< scratch: a set of vertices
  std::span<Word> inner_;     ///< graph of around_
  std::span<Word> left_;      ///< of each level: who may be added
  std::span<Word> branches_;  ///< of each level: whom to try yet
  std::span<Word> class_;     ///< scratch: a colour
  UnitCredit credit_;
  ConsistentSetCounts counts_;
};

}  // namespace sortie::mapping
