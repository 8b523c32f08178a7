// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/ground_path/ground_halls.hpp"

#include <cmath>

namespace sortie::bench {

using planner::GroundPose;
using planner::GroundState;

GroundHall draw_hall(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  GroundHall hall;
  hall.side_m = 12.8;
  for (const double x : {3.2, 6.4, 9.6}) {
    // What is left of the wall between two doors of 1.5 m.
    const double first = between(0.3, 5.0);
    const double second = between(6.6, 11.1);
    hall.patches.push_back({x, 0.0, 0.1, first, planner::kBlockedStand});
    hall.patches.push_back({x, first + 1.5, 0.1, second - first - 1.5, planner::kBlockedStand});
    hall.patches.push_back({x, second + 1.5, 0.1, hall.side_m - second - 1.5, planner::kBlockedStand});
  }
  for (int i = 0; i < 12; ++i)
    hall.patches.push_back({between(2.2, 10.4), between(0, 12.6), 0.2, 0.2, planner::kBlockedStand});
  for (int i = 0; i < 25; ++i)
    hall.patches.push_back({between(0, 12), between(0, 12), between(0.4, 2.0), between(0.4, 2.0),
                            static_cast<std::uint8_t>(between(8, 100))});
  hall.start_x_m = 1.2;
  hall.start_y_m = between(1.5, 11.3);
  hall.goal_x_m = 11.6;
  hall.goal_y_m = between(1.5, 11.3);
  return hall;
}

planner::GroundPathConfig hall_config(const GroundHall& hall, std::int32_t cell_mm) {
  planner::GroundPathConfig config;
  config.nx = config.ny = static_cast<std::int32_t>(std::lround(1e3 * hall.side_m / cell_mm));
  config.cell_mm = cell_mm;
  return config;
}

void lay_out(const GroundHall& hall, planner::test::OwnedGround& ground) {
  const std::int32_t n = ground.config.nx;
  const double cell_m = 1e-3 * ground.config.cell_mm;
  ground.fill(0, 0, n, n, GroundState::carries);
  for (const HallPatch& patch : hall.patches) {
    for (std::int32_t y = 0; y < n; ++y) {
      for (std::int32_t x = 0; x < n; ++x) {
        const double dx = x * cell_m;
        const double dy = y * cell_m;
        if (patch.price == planner::kBlockedStand) {
          constexpr double kHair = 1e-6;  // what ends at a cell's edge does not touch it
          if (dx + cell_m > patch.x_m + kHair && dx < patch.x_m + patch.length_m - kHair &&
              dy + cell_m > patch.y_m + kHair && dy < patch.y_m + patch.width_m - kHair)
            ground.set(x, y, GroundState::blocked);
          continue;
        }
        const double mx = dx + 0.5 * cell_m - patch.x_m;
        const double my = dy + 0.5 * cell_m - patch.y_m;
        if (mx < 0 || my < 0 || mx >= patch.length_m || my >= patch.width_m) continue;
        for (std::int32_t h = 0; h < planner::kHeadings; ++h) {
          const bool across = (h + 2) % 8 >= 4;
          ground.posture(x, y, 0, h) =
              static_cast<std::uint8_t>(across ? patch.price + patch.price / 5 : patch.price);
        }
      }
    }
  }
}

GroundPose hall_start(const GroundHall& hall, std::int32_t cell_mm) {
  return {static_cast<std::int32_t>(1e3 * hall.start_x_m / cell_mm),
          static_cast<std::int32_t>(1e3 * hall.start_y_m / cell_mm), 0, 0};
}
GroundPose hall_goal(const GroundHall& hall, std::int32_t cell_mm) {
  return {static_cast<std::int32_t>(1e3 * hall.goal_x_m / cell_mm),
          static_cast<std::int32_t>(1e3 * hall.goal_y_m / cell_mm), 0, planner::kAnyHeading};
}

}  // namespace sortie::bench
