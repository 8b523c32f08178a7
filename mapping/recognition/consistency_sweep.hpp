// SPDX-License-Identifier: BSD-3-Clause
// All pairs of correspondences, tested for consistency in one sweep: nothing is kept between two jobs.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/recognition/bit_graph.hpp"
#include "mapping/recognition/consistency_gate.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/arena.hpp"
#include "rt/status.hpp"

namespace sortie::mapping {

/// Makes the graphs of consistent pairs, one a gate. 64 pairs at a time are tested in single precision, in
/// loops that a compiler turns into vectors, by bounds wide enough for its rounding; what passes is tested
/// exactly (gates_passed). Where 64 targets are all further from a row's than the local map is wide they are
/// left out. So the result is that of testing each pair exactly, whatever the budgets. Cost: 8 units for 64
/// pairs, 8 for one that passes; a unit is about what a search for sets takes for 64 vertices. Memory: 67
/// bytes and three bits for each other one a correspondence. No heap.
class ConsistencySweep {
 public:
  static constexpr std::uint32_t kMostVertices = 8'192;
  static constexpr std::int32_t kMostPlaceCm = 500'000'000;  ///< along x, y or z from the frame's origin

  /// Whether a place lies within kMostPlaceCm.
  static bool is_near(const PlaceCm& place) {
    const auto inside = [](std::int32_t cm) { return cm >= -kMostPlaceCm && cm <= kMostPlaceCm; };
    return inside(place.x) && inside(place.y) && inside(place.z);
  }

  /// Room for `most` correspondences, at most kMostVertices.
  ConsistencySweep(std::uint32_t most, rt::Arena& arena);

  /// Begins; nothing of `pairs` is read later. Each correspondence comes once, all of one segment with one
  /// place, all of one target, too. out_of_range: gates that are not usable(), a place beyond kMostPlaceCm;
  /// full: more pairs than there is room for. Then the graphs are empty. Costs no units, and sorts the pairs.
  [[nodiscard]] Status begin(const ConsistencyGates& gates, std::span<const SweptPair> pairs);
  /// Goes on for at most `units` and one row's words, takes what it used off. True: the graphs are whole.
  bool run(std::uint64_t& units);

  /// In the order of the vertices: by place of the target, then target, then segment.
  std::span<const SweptPair> pairs() const { return pairs_.first(vertices_); }
  /// Number of a vertex's correspondence in the list that was given.
  std::uint16_t number(std::uint32_t vertex) const { return number_[vertex]; }
  /// Of one gate; each has all edges of the one before.
  BitGraph graph(std::uint32_t gate) const { return graphs_[gate]; }

 private:
  static constexpr std::uint32_t kLanes = BitGraph::kWordBits;
  /// 64 vertices as the test reads them: places relative to the first ones, cm.
  struct Columns {
    float local[3][kLanes];
    float known[3][kLanes];
    float rise[kLanes];  ///< the target's height less the segment's
  };
  struct Box {
    std::int32_t least[4];  ///< x, y, z of 64 targets, and the rise
    std::int32_t most[4];
    bool exact{};  ///< all of it can be said in single precision
  };

  void sort(std::span<const SweptPair> pairs);
  void fill_columns();
  void list_near(const SweptPair& row);
  BitGraph::Word test(const SweptPair& row, std::uint32_t word) const;
  bool test_word(std::uint32_t row, std::uint32_t word, std::uint64_t& units);

  ConsistencyGates gates_;
  std::uint32_t vertices_{};
  std::uint32_t words_{};
  std::int32_t reach_cm_{};  ///< no pair of targets further apart along x or y is consistent
  bool exact_{};             ///< so can the local map
  std::uint32_t row_{};
  std::uint32_t near_at_{};
  std::uint32_t near_count_{};
  BitGraph::Word passed_{};  ///< of the word at hand, still to be tested exactly
  bool word_open_{};
  bool row_open_{};
  std::span<std::uint64_t> keys_;
  std::span<std::uint16_t> number_;
  std::span<SweptPair> pairs_;
  std::span<Columns> columns_;
  std::span<Box> boxes_;
  std::span<std::uint16_t> near_;  ///< words of columns that a row is tested with
  std::span<BitGraph::Word> bits_[ConsistencyGates::kCount];
  BitGraph graphs_[ConsistencyGates::kCount];
  UnitCredit credit_;
};

}  // namespace sortie::mapping
