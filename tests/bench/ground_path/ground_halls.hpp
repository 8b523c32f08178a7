// SPDX-License-Identifier: BSD-3-Clause
// Halls for the ground planner: walls with doors, pillars, rubble of some height; what stands where is in
// metres, so that the same hall can be laid out in cells of any size.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/planner/ground_rig.hpp"

namespace sortie::bench {

/// A rectangle of the hall, m, and what is on it.
struct HallPatch {
  double x_m{};
  double y_m{};
  double length_m{};
  double width_m{};
  std::uint8_t price{};  ///< kBlockedStand: nobody can be there
};

/// A hall, and a question.
struct GroundHall {
  double side_m{};
  std::vector<HallPatch> patches;
  double start_x_m{}, start_y_m{};
  double goal_x_m{}, goal_y_m{};
};

/// The hall of a seed: 12.8 m long and wide, three walls of two doors each, 12 pillars, 25 patches of rubble.
GroundHall draw_hall(std::uint32_t seed);

/// The usual robot (0.8 x 0.6 m, 0.3 m/s, 0.2 m/s back, 0.6 rad/s) on cells of so many mm.
planner::GroundPathConfig hall_config(const GroundHall& hall, std::int32_t cell_mm);

/// Room for every pose; the least price of each cell is known.
inline planner::test::GroundRoom hall_room() { return {SIZE_MAX, SIZE_MAX, 1024, true}; }

/// Lays a hall out in cells: a cell that a wall touches is blocked; a posture costs what its cell's middle
/// does, a fifth more across x than along it.
void lay_out(const GroundHall& hall, planner::test::OwnedGround& ground);

/// Start and goal: headings along x, and any.
planner::GroundPose hall_start(const GroundHall& hall, std::int32_t cell_mm);
planner::GroundPose hall_goal(const GroundHall& hall, std::int32_t cell_mm);

}  // namespace sortie::bench
