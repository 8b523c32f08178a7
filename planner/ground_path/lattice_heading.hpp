// SPDX-License-Identifier: BSD-3-Clause
// The sixteen headings of the ground lattice: those that lead from cell to cell without a remainder.
#pragma once

#include <array>
#include <cstdint>

#include "rt/describe.hpp"

namespace sortie::planner {

inline constexpr std::int32_t kHeadings = 16;

/// A step over the lattice, cells: x to the map's x, y to its left.
struct CellStep {
  std::int32_t x{};
  std::int32_t y{};
  SORTIE_FIELDS(x, y)
  friend constexpr bool operator==(const CellStep&, const CellStep&) = default;
};

/// Where heading i looks, counted to the left from x: along an axis, a diagonal, or a knight's move between.
/// The angles between them are 26.6 and 18.4 degrees; in return a straight way never leaves the lattice.
inline constexpr std::array<CellStep, kHeadings> kHeadingSteps{{{1, 0},
                                                                {2, 1},
                                                                {1, 1},
                                                                {1, 2},
                                                                {0, 1},
                                                                {-1, 2},
                                                                {-1, 1},
                                                                {-2, 1},
                                                                {-1, 0},
                                                                {-2, -1},
                                                                {-1, -1},
                                                                {-1, -2},
                                                                {0, -1},
                                                                {1, -2},
                                                                {1, -1},
                                                                {2, -1}}};

/// Heading of any count of turns.
constexpr std::int32_t wrap_heading(std::int32_t heading) { return heading & (kHeadings - 1); }

/// Length of kHeadingSteps[heading], cells in 1/65536: 1, sqrt 5 or sqrt 2.
constexpr std::int64_t step_length_q16(std::int32_t heading) {
  if (heading % 2 != 0) return 146543;
  return heading % 4 == 0 ? 65536 : 92682;
}

/// Angle from `heading` to the next one on its left, 1/1000 rad.
constexpr std::int64_t turn_left_mrad(std::int32_t heading) {
  const std::int32_t within = heading & 3;
  return within == 0 || within == 3 ? 464 : 322;
}

/// Half of a curve's control polygon: about two cells along a heading, whole.
constexpr CellStep curve_leg(std::int32_t heading) {
  const CellStep step = kHeadingSteps[static_cast<std::size_t>(heading)];
  const std::int32_t times = heading % 4 == 0 ? 2 : 1;
  return {times * step.x, times * step.y};
}

}  // namespace sortie::planner
