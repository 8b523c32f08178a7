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

/// A correspondence, and where its two segments are.
struct SweptPair {
  Correspondence pair;
  PlaceCm segment;  ///< in the local map
  PlaceCm target;   ///< in the known map
  SORTIE_FIELDS(pair, segment, target)
};

/// Makes the graph of consistent pairs. Two of one segment, or of one target, are not consistent. 64 pairs
/// are tested at a time, in loops that a compiler turns into vectors; where 64 targets are all further from a
/// row's than the local map is wide, their word is left out. The result is that of testing each pair by
/// `pair_range`, whatever the budgets. Cost: 16 units for a word of 64 pairs, and for each segment one a
/// segment and one four correspondences; a unit is about what a test of four pairs takes. Memory:
/// kBytesAVertex, and a bit for each other one. No heap.
class ConsistencySweep {
 public:
  static constexpr std::uint32_t kMostVertices = 8'192;
  static constexpr std::int32_t kMostPlaceCm = 500'000'000;  ///< along x, y or z from the frame's origin

  /// Room for `most` correspondences, at most kMostVertices.
  ConsistencySweep(std::uint32_t most, rt::Arena& arena);

  /// Begins; nothing of `pairs` is read later. Each correspondence comes once, all of one segment with one
  /// place, all of one target, too. out_of_range: a gate that is not usable(), a place beyond kMostPlaceCm;
  /// full: more pairs than there is room for. Then the graph is empty.
  [[nodiscard]] Status begin(const ConsistencyGate& gate, std::span<const SweptPair> pairs);
  /// Goes on for at most `units` and one step, takes what it used off. True: the graph is whole.
  bool run(std::uint64_t& units);

  /// Vertex v of the graph stands for pairs[order()[v]]: by place of the target, then target, then segment.
  std::span<const std::uint16_t> order() const { return order_.first(vertices_); }
  BitGraph graph() const { return graph_; }

 private:
  static constexpr std::uint32_t kLanes = BitGraph::kWordBits;
  /// 64 vertices as the test reads them.
  struct Columns {
    std::int16_t x[kLanes];  ///< of the target, cm, the low 16 bits
    std::int16_t y[kLanes];
    std::int16_t z[kLanes];
    std::int16_t rise[kLanes];  ///< the target's height less the segment's
    // For the row's segment, shifted so that one comparison of signed numbers tests both ends.
    std::int16_t rise_least[kLanes];
    std::int16_t rise_span[kLanes];
    std::uint32_t least[kLanes];
    std::int32_t span[kLanes];
    // Of the segment.
    double segment[3][kLanes];
    std::int32_t group[kLanes];
  };
  struct Box {
    std::int32_t least[4];  ///< x, y, z of 64 targets, and the rise
    std::int32_t most[4];
  };
  struct Vertex {
    std::int32_t at[4]{};   ///< x, y, z of the target, and the rise
    std::uint16_t group{};  ///< number of its segment, from 0
    std::uint16_t other{};  ///< the first vertex behind it that has another target
  };
  static constexpr std::uint32_t kNoGroup = ~0u;
  enum class Step : std::uint8_t { done, rows, mirror };

  void sort(std::span<const SweptPair> pairs);
  void list_groups(std::span<const SweptPair> pairs);
  void fill_columns(std::span<const SweptPair> pairs);
  void measure(std::span<const SweptPair> pairs);
  void open_group(std::uint32_t vertex);
  BitGraph::Word test(const Vertex& row, const Columns& columns) const;
  BitGraph::Word without_far(const Vertex& row, std::uint32_t word, BitGraph::Word bits) const;
  void list_near(const Vertex& row);
  void test_row(std::uint32_t vertex);
  void mirror(std::uint32_t word);

  ConsistencyGate gate_;
  std::uint32_t vertices_{};
  std::uint32_t words_{};
  std::int32_t reach_cm_{};  ///< no pair of targets further apart along x or y is consistent
  bool wide_{};              ///< low 16 bits do not tell all places apart
  Step step_{Step::done};
  std::uint32_t at_{};  ///< row in rows_, or word of columns
  std::uint32_t group_{kNoGroup};  ///< that the columns are made for
  std::span<std::uint64_t> keys_;
  std::span<std::uint16_t> order_;
  std::span<std::uint16_t> rows_;  ///< vertices by group
  std::span<Vertex> vertex_;
  std::span<Columns> columns_;
  std::span<Box> boxes_;
  std::span<std::uint16_t> near_;  ///< words of columns that a row is tested with
  std::uint32_t near_count_{};
  std::span<BitGraph::Word> bits_;
  BitGraph graph_;
  UnitCredit credit_;
};

}  // namespace sortie::mapping
