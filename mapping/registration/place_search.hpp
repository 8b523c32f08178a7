// SPDX-License-Identifier: BSD-3-Clause
// Where on a map a scan may have been taken: all places, all turns about the upright, best first.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/place_map.hpp"
#include "mapping/registration/relocate_config.hpp"
#include "mapping/registration/unit_credit.hpp"
#include "rt/archive.hpp"

namespace sortie::mapping {

/// A pose of the search, and how many returns lie near a surface there, plus how many lie on one.
struct PlaceCandidate {
  PlaceCell cell;
  std::uint32_t hits{};
  SORTIE_FIELDS(cell, hits)
};

/// Work of a search.
struct PlaceSearchCounts {
  std::uint64_t tops{};   ///< looked at, 64 nodes each
  std::uint64_t parts{};  ///< eight nodes at once looked at by their parts
  std::uint64_t nodes{};  ///< looked at, 64 poses each
  std::uint64_t units{};
  SORTIE_FIELDS(tops, parts, nodes, units)
};

/// Branch and bound over x, y, z and the turn. Poses stand half a cell apart and
/// 360 / 256 degrees. First each node of 4 x 4 x 4 poses gets, for each turn, the most hits that any of its
/// poses can have; then nodes are looked at by their parts and opened, most hits first. What it finds is
/// exactly what looking at every pose finds. A unit is one look at one return for 64 poses; each takes two.
/// Memory: 64 bytes a top a turn, and 0.3 MB. No heap.
class PlaceSearch {
 public:
  static constexpr std::int32_t kTurns = 256;
  /// Two poses are the same place within so many steps along each axis and so many of the turn.
  static constexpr std::int32_t kNearSteps = 4;
  static constexpr std::int32_t kNearTurns = 6;

  /// `map` outlives it.
  PlaceSearch(const PlaceSearchConfig& config, const PlaceMap& map, rt::Arena& arena);

  /// Begins with returns of a level frame, m: at most kMostReturns. Nothing is searched where there are none.
  void begin(std::span<const rt::Vector3> returns_m);
  /// Searches on for at most `units`, takes what it used off. True: it is done.
  bool run(std::uint64_t& units);

  /// Candidates, then rivals of the best; most hits first. Of as many, the one that comes first by turn, node
  /// and pose. No two of them are the same place; none has fewer hits than the config wants.
  std::span<const PlaceCandidate> found() const { return {found_, found_count_}; }
  const PlaceSearchConfig& config() const { return config_; }
  std::size_t returns() const { return return_count_; }
  const PlaceSearchCounts& counts() const { return counts_; }
  /// Turn of a pose about the upright.
  static double turn_rad(std::int32_t turn);

  /// The pose of a lane of a node; nodes are numbered by tops along x, y, z and in them as lanes of a block.
  PlaceCell cell(std::int32_t turn, std::uint32_t node, int lane) const;
  /// Fewest hits that a candidate, or a rival of the best one, may have, with those that were found so far.
  std::uint32_t least_hits(bool rival) const;
  /// Whether rivals of the best one are looked for at a turn: its own, or a quarter or half a turn from it,
  /// and the steps next to these. Rooms that look like another one do so there.
  bool is_rivals_turn(std::int32_t turn) const;
  /// Two poses are one place.
  static bool near(const PlaceCell& a, const PlaceCell& b);

  /// The map is the same, or is built before this reads.
  void archive(rt::Archive& archive);

 private:
  enum class Step : std::uint8_t { done, bounds, picks, rivals };
  void turn_returns();
  void take_turn();
  bool run_bounds(std::uint64_t& units);
  bool run_picks(std::uint64_t& units);
  bool pick_in_turn(std::uint64_t& units);
  bool pay(std::uint64_t cost, std::uint64_t& units);
  bool narrow(std::uint32_t node, std::uint64_t& units);
  void open(std::uint32_t node);
  std::uint32_t most_found() const;
  bool is_taken(const PlaceCell& cell) const;
  std::uint32_t nodes() const { return static_cast<std::uint32_t>(map_->tops()) * PlaceTiles::kLanes; }
  std::span<std::uint8_t> bounds_of(std::int32_t turn) {
    return bounds_.subspan(static_cast<std::size_t>(turn) * nodes(), nodes());
  }

  PlaceSearchConfig config_;
  const PlaceMap* map_;
  std::span<std::uint8_t> bounds_;     ///< most hits of the poses of a node that are not taken
  std::span<PlaceOffset> offsets_;     ///< of each turn's returns
  std::span<std::uint8_t> narrowed_;   ///< a bit for each eight nodes of a top and turn
  std::span<PlaceTiles::Look> looks_;  ///< of the turn at hand
  std::span<PlaceTiles::Look> part_looks_;
  std::int32_t looks_turn_{-1};
  Step step_{Step::done};
  rt::Vector3 returns_m_[PlaceSearchConfig::kMostReturns];
  std::uint32_t return_count_{};
  std::int32_t turn_{};
  std::uint32_t at_{};           ///< the top or the node that is next
  std::uint32_t level_{};        ///< hits of the nodes that are being opened
  std::uint32_t rest_{};         ///< most bound of the turn's nodes so far
  bool paid_{};                  ///< for looking through the turn's nodes
  std::uint8_t most_[kTurns]{};  ///< bound of each turn's nodes
  PlaceCandidate found_[PlaceSearchConfig::kMostCandidates];
  std::uint32_t found_count_{};
  std::uint32_t candidate_count_{};  ///< of them, before rivals were looked for
  UnitCredit credit_;
  PlaceSearchCounts counts_;
};

}  // namespace sortie::mapping
