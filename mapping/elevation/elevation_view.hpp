// SPDX-License-Identifier: BSD-3-Clause
// What others see of the elevation map: the ground of a cell as a span of heights, and how it is known.
#pragma once

#include <cstdint>

#include "mapping/elevation/elevation_cell.hpp"

namespace sortie::mapping {

/// What is known of the ground in a cell. Unknown is a state, never a number.
enum class GroundState : std::uint8_t {
  unknown,   ///< nothing; also outside the window
  bounded,   ///< not seen, but rays passed over it: along their ways the ground is below `bound_m`
  measured,  ///< seen
  felt,      ///< its upper surface carries, or carried, the robot
};

/// The ground of one cell at one level. Heights in the world, m.
struct GroundSpan {
  GroundState state{GroundState::unknown};
  bool from_below{};   ///< measured, but only by rays that went up: a ramp, or the underside of a floor
  bool has_bound{};    ///< bound_m holds, also beside a measurement
  bool has_ceiling{};  ///< ceiling_m holds
  double low_m{};      ///< lower surface: where the cell holds no edge the same as high_m
  double high_m{};     ///< upper surface
  double sigma_m{};    ///< standard deviation of the less certain one, 0.64 where it is that or more
  double bound_m{};    ///< rays passed at this height
  double ceiling_m{};  ///< lowest surface of the next level above
};

/// How a query tells one level from another.
struct LevelRule {
  double clearance_m{0.7};  ///< surfaces with a gap of this height are two levels, but in a cell with kFilled
  double climb_m{0.45};     ///< a level that begins higher than this above the asker is not the ground there
  double reach_m{1.5};      ///< bounds that lie deeper than this below the asker are of another level
};

/// A square window of cells. The memory belongs to the map and changes with it; the view holds until the map
/// rolls or takes a scan.
struct ElevationView {
  static constexpr std::int32_t kNoBound = INT32_MAX;

  const ElevationCell* cells{};
  const CellEvidence* evidence{};
  const std::int32_t* bounds{};  ///< height over which rays passed a cell, kNoBound without
  std::int32_t size{};           ///< cells along x and y, a power of two
  std::int64_t low[2]{};         ///< world number of the window's first cell: it spans low .. low + 1 cells
  std::int32_t cell_units{};     ///< edge of a cell, kGroundUnits
  std::int64_t level_m{};        ///< heights count from here
  std::uint32_t variance{};      ///< what motion has added until now

  /// World number of the cell of a coordinate (m, finite, below 1e9).
  std::int64_t cell_of(double world_m) const;
  bool contains(std::int64_t x, std::int64_t y) const {
    return x >= low[0] && x < low[0] + size && y >= low[1] && y < low[1] + size;
  }
  /// Where a cell of the window lies in the two arrays. It stays there while the window rolls.
  std::uint32_t index(std::int64_t x, std::int64_t y) const {
    const auto mask = static_cast<std::uint64_t>(size - 1);
    return static_cast<std::uint32_t>((static_cast<std::uint64_t>(y) & mask) *
                                          static_cast<std::uint64_t>(size) +
                                      (static_cast<std::uint64_t>(x) & mask));
  }

  /// The ground of a cell (world numbers) for somebody who stands at `asker_m`: the highest level that does
  /// not begin more than `climb_m` above. Where all levels do, the ground is not known and the lowest of them
  /// is the ceiling. What was seen from below alone counts as ground only where nothing above it was seen
  /// from above. Cost: about 20 ns.
  GroundSpan ground(std::int64_t x, std::int64_t y, double asker_m, const LevelRule& rule = {}) const;
  /// The same at a place in the world; unknown where it is not finite.
  GroundSpan ground_at(double x_m, double y_m, double asker_m, const LevelRule& rule = {}) const;
};

}  // namespace sortie::mapping
