// SPDX-License-Identifier: BSD-3-Clause
// Halls drawn at random, flown on the map of the vehicle's own lidar: rooms in a row behind walls that have
// doors and windows anywhere, off the map's voxels. The truth is held against every box.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tests/firmware_like/met_a_box.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {

/// What a flight on a sensed map needs beside the scene. With these sizes an opening of 1.95 m is always wide
/// enough (docs/uav-runtime.md has the rule).
inline std::vector<std::string> sensed_hall_overrides() {
  return {"flight_map.source=lidar",
          "flight_map.margin_m=0.05",
          "occupancy.window_x_m=38.4",
          "occupancy.window_y_m=19.2",
          "occupancy.window_z_m=6.4",
          "occupancy.max_range_m=20.0",
          "lidar.z_m=0.1",
          "hil.lidar_hz=10",
          "hil.lidar_rows=32",
          "hil.lidar_columns=180"};
}

struct RandomHall {
  std::vector<TrueBox> boxes;
  std::string goals;
};

/// Two or three walls across 16 m x 8 m x 3 m, each with one or two openings of 2 to 2.6 m: doors to the
/// ceiling or with a lintel, or windows of 1.4 to 1.7 m. One goal at the far end, one beside the start.
inline RandomHall draw_hall(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  constexpr double kHigh = 3.0;
  RandomHall hall;
  const auto box = [&hall](double x, double y, double z, double l, double w, double h) {
    if (w > 1e-3 && h > 1e-3) hall.boxes.push_back({{x, y, z}, {l, w, h}});
  };
  box(-2, -4, kHigh, 16, 8, 0.2);
  box(-2, -4, 0, 16, 0.2, kHigh);
  box(-2, 3.8, 0, 16, 0.2, kHigh);
  box(-2, -3.8, 0, 0.2, 7.6, kHigh);
  box(13.8, -3.8, 0, 0.2, 7.6, kHigh);
  for (double x = between(3, 5); x < 10.5; x += between(3.2, 4.5)) {
    const double thick = between(0.08, 0.3);
    const bool two = random() % 3 == 0;
    double from_y = -3.8;
    for (int opening = 0; opening < (two ? 2 : 1); ++opening) {
      const double wide = between(2.0, 2.6);
      const double last = two && opening == 0 ? -0.1 - wide : 3.6 - wide;
      const double y = between(opening == 0 ? -3.6 : std::max(from_y + 0.3, 0.3), last);
      const bool window = random() % 2 == 0;
      const double z0 = window ? between(0.5, 0.9) : 0.0;
      const double z1 = window ? z0 + between(1.4, 1.7) : random() % 2 == 0 ? kHigh : 2.2;
      box(x, from_y, 0, thick, y - from_y, kHigh);
      box(x, y, 0, thick, wide, z0);
      box(x, y, z1, thick, wide, kHigh - z1);
      from_y = y + wide;
    }
    box(x, from_y, 0, thick, 3.8 - from_y, kHigh);
  }
  const auto goal = [](double x, double y, double z) {
    return "{x_m=" + std::to_string(x) + ",y_m=" + std::to_string(y) + ",z_m=" + std::to_string(z) +
           ",wait_s=0.5}";
  };
  hall.goals = "mission.goals=[" + goal(12.4, between(-2.2, 2.2), between(1, 2)) + "," +
               goal(0, between(-2, 2), between(1, 1.6)) + "]";
  return hall;
}

/// Scene uav_hall, or a scene file, in simulated time on a sensed map.
inline firmware::LiveRunOutcome fly_sensed(const std::string& scene, double seconds,
                                           std::vector<std::string> more) {
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = sensed_hall_overrides();
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.seconds = seconds;
  options.virtual_time = true;
  options.lcm_url = "none";
  return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
}

}  // namespace sortie::testing
