// SPDX-License-Identifier: BSD-3-Clause
// How far is the goal from every cell at least? The lattice without headings, at the least prices,
// walked back from the goal: what the search is led by, and why it can prove that a way is the cheapest.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "planner/ground_path/motion_table.hpp"
#include "planner/ground_path/stand_prices.hpp"

namespace sortie::planner {

/// What is kept of a surface of a cell. 12 bytes.
struct DistanceNode {
  std::uint32_t cost{};
  std::uint32_t before{};  ///< in its bucket
  std::uint32_t after{};
};

/// Memory of the distances: two nodes a cell.
struct DistanceMemory {
  std::span<DistanceNode> nodes;
};

/// Dijkstra's algorithm with buckets, of which each is as wide as the cheapest step, so that none is sorted
/// (Dial 1969). Each motion of the lattice is at least as dear as the steps that stand for it here, and needs
/// at least the cells that all slots share: so these distances are never too long, and no motion is cheaper
/// than what it brings nearer. It ends a quarter beyond the start; from there on all is as far as that.
class GoalDistance {
 public:
  /// Work units of a surface that is settled.
  static constexpr std::uint32_t kUnitsPerNode = 8;

  GoalDistance(const GroundPathConfig& config, const MotionTable& motions, const DistanceMemory& memory);

  /// Starts anew, towards a surface of a cell that is inside of the map. The nodes are cleared by step().
  void begin(const GroundMap& map, const GroundPose& goal, const GroundPose& start);

  /// Settles the next bucket's first surface; false when nothing is left to do. Adds to `units`.
  bool step(const GroundMap& map, StandPrices& prices, std::uint64_t& units);

  /// True when the start was reached.
  bool is_start_reached() const { return is_start_reached_; }
  /// True when something was left out because it is farther than kMostCost.
  bool is_cut() const { return is_cut_; }
  /// The least cost from a surface to the goal.
  std::uint32_t cost(std::uint32_t place) const {
    const std::uint32_t known = nodes_[place].cost;
    return known < limit_ ? known : limit_;
  }

 private:
  static constexpr std::uint32_t kBuckets =
      128;  // more than the dearest edge reaches on, with all times rounded
  static constexpr std::uint32_t kNone = UINT32_MAX;
  struct Edge {
    std::int8_t x{};
    std::int8_t y{};
    std::uint32_t ms{};
  };
  void put(std::uint32_t place, std::uint32_t cost);
  void take(std::uint32_t place);
  struct Place {
    std::int32_t x{};
    std::int32_t y{};
    std::int32_t height_mm{};
    std::uint32_t cost{};
    std::uint32_t per_ms{};
  };
  void relax(const GroundMap& map, StandPrices& prices, const Place& from, const Edge& edge,
             std::uint64_t& units);

  std::array<Edge, 3 * kHeadings> edges_{};
  std::uint32_t width_{1};
  std::int32_t reach_mm_{};
  bool over_unknown_{};
  std::uint8_t unknown_price_{};
  std::span<DistanceNode> nodes_;
  std::size_t cleared_{};  // of them, since begin()
  std::array<std::uint32_t, kBuckets> first_{};
  std::uint32_t bucket_{};  ///< number of the current one, not wrapped
  std::uint32_t queued_{};
  std::uint32_t limit_{kNone};
  std::uint32_t start_{};
  std::uint32_t goal_{};
  bool is_start_reached_{};
  bool is_cut_{};
};

}  // namespace sortie::planner
