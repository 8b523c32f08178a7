// SPDX-License-Identifier: BSD-3-Clause
// What the ground planner is told about the map, the robot and what is unknown.
#pragma once

#include <cstdint>

#include "rt/status.hpp"

namespace sortie::planner {

/// What happens where the ground was not seen.
enum class UnknownGround : std::uint8_t {
  blocked,     ///< nothing is planned over it
  by_price,    ///< planned over at `unknown_price`; never driven: see GroundPath::drivable()
  look_first,  ///< the same, and each entry costs `look_ms`: the robot stops and looks
};

/// Size of the lattice, of the robot and of its speeds. Whole numbers: they give the same plan on every
/// board.
struct GroundPathConfig {
  std::int32_t nx{128};  ///< cells, at most 512
  std::int32_t ny{128};
  std::int32_t cell_mm{100};
  std::int32_t half_length_mm{400};  ///< of the rectangle that must be carried
  std::int32_t half_width_mm{300};
  std::int32_t speed_mm_s{300};
  std::int32_t reverse_mm_s{200};  ///< at most speed_mm_s
  std::int32_t turn_mrad_s{600};   ///< on the spot, and the most in a curve
  /// Ground this much higher or lower than where the robot's middle stands is another floor, a wall or a
  /// drop.
  std::int32_t reach_mm{500};
  UnknownGround unknown{UnknownGround::blocked};
  std::uint8_t unknown_price{48};
  std::int32_t look_ms{4000};
  /// Cells around a pose beyond the footprint that PostureSource looks at.
  std::int32_t posture_margin_cells{0};
};

/// Prices of a pose. A second at price p costs 1 + p / 16 seconds.
inline constexpr std::uint8_t kMostPrice = 200;
inline constexpr std::uint8_t kUnknownStand = 254;  ///< the footprint holds ground that was not seen
inline constexpr std::uint8_t kBlockedStand = 255;  ///< it holds ground that does not carry

/// Costs are 1/16 ms; a way that is dearer than this (18 h) counts as too far.
inline constexpr std::uint32_t kMostCost = 1u << 30;
inline constexpr std::uint32_t kCostPerMs = 16;

/// ok, or out_of_range: a size, a speed or a price that nothing can be planned with.
constexpr Status check(const GroundPathConfig& c) {
  const auto within = [](std::int32_t value, std::int32_t low, std::int32_t high) {
    return value >= low && value <= high;
  };
  const bool good = within(c.nx, 1, 512) && within(c.ny, 1, 512) && within(c.cell_mm, 10, 1000) &&
                    within(c.half_length_mm, 1, 12 * c.cell_mm) &&
                    within(c.half_width_mm, 1, c.half_length_mm) && within(c.speed_mm_s, 10, 10'000) &&
                    within(c.reverse_mm_s, 10, c.speed_mm_s) && within(c.turn_mrad_s, 10, 20'000) &&
                    within(c.reach_mm, 0, 5'000) && c.unknown_price <= kMostPrice &&
                    within(c.look_ms, 0, 60'000) && within(c.posture_margin_cells, 0, 8) &&
                    c.unknown <= UnknownGround::look_first;
  return good ? Status::ok : Status::out_of_range;
}

}  // namespace sortie::planner
