// SPDX-License-Identifier: BSD-3-Clause
// Which cells the robot may need when it stands somewhere near a cell's middle, with a heading or between
// two.
#pragma once

#include <array>
#include <cstdint>

#include "planner/ground_path/motion_table.hpp"

namespace sortie::planner {

/// Cells low to high of one row of a footprint, from the middle; none where low > high.
struct FootprintRow {
  std::int8_t low{1};
  std::int8_t high{0};
};

/// For each slot the cells that the robot's rectangle touches at any place and heading which the slot stands
/// for (MotionStation): so what holds for the stations of a motion holds for all of the motion. Cells are too
/// many by less than one at each border. Whole numbers; 3 kB; made once.
class FootprintTable {
 public:
  static constexpr std::int32_t kMostReach = 20;
  /// Slot of the cells that all others share.
  static constexpr std::int32_t kCore = kStandSlots;

  explicit FootprintTable(const GroundPathConfig& config);

  /// Row `y`, -reach() to reach(), of a slot or of kCore.
  const FootprintRow& row(std::int32_t slot, std::int32_t y) const {
    return rows_[static_cast<std::size_t>(slot)][static_cast<std::size_t>(y + kMostReach)];
  }
  /// Cells to the farthest one along an axis, of a slot and of all.
  std::int32_t reach(std::int32_t slot) const { return reaches_[static_cast<std::size_t>(slot)]; }
  std::int32_t reach() const { return reach_; }

 private:
  void add(std::int32_t slot, const GroundPathConfig& config, std::int64_t a, std::int64_t b,
           std::int64_t wider_mm);

  std::array<std::array<FootprintRow, 2 * kMostReach + 1>, kStandSlots + 1> rows_{};
  std::array<std::int32_t, kStandSlots + 1> reaches_{};
  std::int32_t reach_{};
};

}  // namespace sortie::planner
