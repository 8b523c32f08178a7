// SPDX-License-Identifier: BSD-3-Clause
// A cheap, safe way over the ground for a tracked robot: over cells, floors and headings, in slices of work,
// with a way at any time after the first was found and a bound of how much cheaper one can be.
#pragma once

#include <cstdint>
#include <span>

#include "planner/ground_path/goal_distance.hpp"
#include "planner/ground_path/ground_map.hpp"
#include "planner/ground_path/heading_columns.hpp"
#include "planner/ground_path/motion_table.hpp"
#include "planner/ground_path/stand_prices.hpp"
#include "planner/uav_path/ordered_heap.hpp"
#include "rt/arena.hpp"

namespace sortie::planner {

/// Where a plan stands.
enum class GroundPathState : std::uint8_t {
  idle,           ///< nothing was asked
  running,        ///< no way yet: the units are spent, the search is not
  found,          ///< there is a way; more work may make it cheaper
  proved,         ///< there is a way, and none is cheaper
  none,           ///< there is no way: all that can be reached was looked at
  capacity,       ///< the memory ended before the search; there may be a way
  open_full,      ///< the open list ended before the search; there may be a way
  too_far,        ///< what can be reached within kMostCost was looked at
  bad_memory,     ///< configuration, map and memory do not fit each other
  start_outside,  ///< start or goal outside of the map, or on a surface that is not there
  goal_outside,
  start_unknown,  ///< ground under the start was not seen
  goal_unknown,
  start_blocked,  ///< the robot cannot stand there
  goal_blocked,
  outdated,  ///< the map changed: ask again
};

/// The goal's heading when any will do.
inline constexpr std::int32_t kAnyHeading = -1;

/// A pose on the way and what was paid up to there.
struct GroundStep {
  GroundPose pose;
  std::uint32_t cost{};   ///< from the start, 1/16 ms at the least prices
  std::uint8_t motion{};  ///< that led here: MotionTable, of the heading before
  bool is_known{true};    ///< all ground of that motion was seen to carry
};

/// Memory of a planner, which outlives it.
struct GroundPathMemory {
  std::span<std::uint8_t> prices;  ///< StandPrices::bytes_for()
  DistanceMemory distances;        ///< two nodes a cell
  ColumnMemory columns;            ///< two words a cell; as many columns as one can spare
  std::span<std::uint32_t> heap;   ///< the open list
  std::span<GroundStep> way;

  /// From an arena: `columns` of the search, entries of the open list, steps of the way. What does not fit is
  /// in the arena's report.
  static GroundPathMemory take(rt::Arena& arena, const GroundPathConfig& config, std::size_t columns,
                               std::size_t open, std::size_t steps);
};

/// What was done, for reports.
struct GroundPathWork {
  std::uint64_t units{};
  std::uint32_t expanded{};
  std::uint32_t rounds{};    ///< of the search, each with a lower weight
  std::uint32_t improved{};  ///< ways that were shown
};

/// Plans one way at a time: anytime repairing A* (Likhachev, Gordon and Thrun 2003), weights 2 to 1. No heap,
/// no clock, no floating point. What it has found after so many units does not depend on how they were
/// sliced. Ground that was not seen to carry is never driven over: not planned at all, or at the far end of a
/// way whose drivable() part ends before.
class GroundPath {
 public:
  /// Work units, of some 65 to 85 ns each on a desk: of a pose whose motions are tried, and of one that is
  /// put in order again.
  static constexpr std::uint32_t kExpandUnits = 8;
  static constexpr std::uint32_t kRepairUnits = 1;

  GroundPath(const GroundPathConfig& config, const PostureSource& source, const GroundPathMemory& memory);

  /// Asks for a way. Start and goal are judged in run(), after what the map changed was worked in. Cost: that
  /// of clearing the tables.
  GroundPathState begin(const GroundMap& map, const GroundPose& start, const GroundPose& goal);

  /// Forgets what postures cost: the next plan is that of a planner that never saw a map, also in its work.
  void forget_prices() { prices_.forget(); }

  /// Works on for `units`; beyond them by one step's at the most, which the next call pays: a way that is
  /// shown is one step. A map that changed since begin(): outdated, and no way, also where all was done. Ask
  /// before each drive.
  GroundPathState run(GroundMap& map, std::uint64_t units);

  GroundPathState state() const { return state_; }
  bool has_way() const { return way_steps_ > 0; }
  /// The best way so far, from the start on, its first steps where the memory ends: see is_whole().
  std::span<const GroundStep> way() const { return way_.first(way_steps_); }
  bool is_whole() const { return is_whole_; }
  /// The part that goes over known ground alone. The rest is a hope, and must be planned again before.
  std::span<const GroundStep> drivable() const { return way_.first(drivable_steps_); }
  /// Of all of the way, 1/16 ms; and no way costs less than lower_bound().
  std::uint32_t cost() const { return best_; }
  std::uint32_t lower_bound() const { return lower_ < best_ ? lower_ : best_; }

  /// Cells that were not seen under the first step behind drivable(): where to look. How many were written.
  std::size_t unseen(const GroundMap& map, std::span<CellStep> cells) const;

  const MotionTable& motions() const { return motions_; }
  const FootprintTable& footprints() const { return prices_.footprints(); }
  const GroundPathWork& work() const { return work_; }

  // For the heap.
  bool comes_before(std::uint32_t a, std::uint32_t b) const {
    const GroundNode& first = columns_[a];
    const GroundNode& second = columns_[b];
    if (first.estimate != second.estimate) return first.estimate < second.estimate;
    return first.cost != second.cost ? first.cost > second.cost : a < b;
  }
  void set_place(std::uint32_t node, std::uint32_t place) { columns_[node].heap_place = place; }

 private:
  static constexpr std::uint32_t kFirstWeight = 32;
  enum class Phase : std::uint8_t { refresh, judge, measure, search, repair };
  struct Try {
    std::uint32_t cost{UINT32_MAX};  // not possible
    bool is_known{true};
  };
  void step(GroundMap& map);
  void judge_ends(const GroundMap& map);
  void search(const GroundMap& map);
  void expand(const GroundMap& map, std::uint32_t node);
  void reach(const GroundMap& map, std::uint32_t from, std::uint32_t motion, std::uint32_t place,
             std::uint32_t cost);
  void open(std::uint32_t node, std::uint32_t to_goal);
  void repair();
  void end_round();
  void show(const GroundMap& map, std::uint32_t last);
  Try attempt(const GroundMap& map, const GroundPose& from, const Motion& motion);
  GroundPose pose_of(const GroundMap& map, std::uint32_t node) const;
  bool is_goal(const GroundPose& pose) const;
  bool is_live() const { return state_ == GroundPathState::running || state_ == GroundPathState::found; }

  GroundPathConfig config_;
  MotionTable motions_;
  StandPrices prices_;
  GoalDistance distances_;
  HeadingColumns columns_;
  OrderedHeap heap_;
  std::uint32_t heap_capacity_;
  std::span<GroundStep> way_;
  bool usable_{};

  GroundPathState state_{GroundPathState::idle};
  Phase phase_{Phase::refresh};
  GroundPose start_;
  GroundPose goal_;
  std::uint32_t map_version_{};
  std::uint64_t granted_{};
  std::uint32_t best_{UINT32_MAX};
  std::uint32_t lower_{};
  std::uint32_t round_{};
  std::uint32_t weight_{};    // 1/16
  std::uint32_t opened_{};    // entries of the heap
  std::uint32_t repaired_{};  // nodes of this repair
  std::uint32_t least_{};     // cost and distance of what is open, the least of this repair
  bool is_cut_{};
  std::size_t way_steps_{};
  std::size_t drivable_steps_{};
  bool is_whole_{};
  GroundPathWork work_;
};

}  // namespace sortie::planner
