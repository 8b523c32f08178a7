// SPDX-License-Identifier: BSD-3-Clause
// Settings of scan-to-map registration.
#pragma once

#include <cstdint>

#include "rt/keys.hpp"

namespace sortie::mapping {

/// The defaults work in a building and around one, with 16 to 128 rows. `planar`: for a lidar of one row.
struct RegistrationConfig {
  double cell_m{0.5};           ///< edge of the finest surfel; the coarser layers have 2 and 4 times it
  double edge_m{0.1};           ///< of the cubes that a scan is thinned to one return in
  std::uint32_t returns{3072};  ///< most of a scan that are matched
  double min_range_m{0.6};
  double max_range_m{60.0};
  std::uint32_t steps{6};             ///< of the finest layer
  std::uint32_t min_points{5};        ///< that make a Gaussian
  std::uint32_t memory_points{8192};  ///< of a cell, before it fades
  double sigma_m{0.02};               ///< a scan's noise, and what a surface is uneven by
  double least_share{0.7};            ///< of the returns where the map has a surface: that must lie on it
  double least_known{0.15};           ///< of the returns: that must fall where the map has a surface
  double good_share{0.85};            ///< below it other starts are tried
  double most_crossed{0.05};          ///< of the rays that may go through surfaces of the map
  double most_inside{0.02};           ///< of the returns: where the scan before saw nothing
  double recovery_turn_rad{1.0472};
  double recovery_move_m{1.0};
  bool planar{};  ///< x, y and yaw alone are matched; height and tilt are the odometry's

  SORTIE_KEYS(c, key) {
    key("cell_m", c.cell_m, {0.05, 5, "m", "edge of a surfel's cell", rt::kKnob});
    key("thin_m", c.edge_m, {0.01, 5, "m", "one return is matched of each cube of this edge", rt::kKnob});
    key("returns", c.returns, {64, 8192, "returns", "most of a scan that are matched", rt::kKnob});
    key("min_range_m", c.min_range_m, {0, 100, "m", "nearer returns are left out"});
    key("max_range_m", c.max_range_m, {0.1, 1000, "m", "farther returns are left out"});
    key("steps", c.steps, {1, 50, "steps", "of the last, finest kind", rt::kKnob});
    key("min_points", c.min_points, {4, 1000, "points", "from which a cell has a surface"});
    key("memory_points", c.memory_points,
        {16, 32768, "points", "that a cell remembers, half of them for long"});
    key("sigma_m", c.sigma_m,
        {0.001, 1, "m", "noise of a return, and what a surface is uneven by", rt::kKnob});
    key("least_share", c.least_share,
        {0, 1, "", "of the returns where the map has a surface, that must lie on it"});
    key("least_known", c.least_known,
        {0, 1, "", "of the returns, that must fall where the map has a surface"});
    key("good_share", c.good_share, {0, 1, "", "below it other starts are tried"});
    key("most_crossed", c.most_crossed, {0, 1, "", "of the rays that may go through the map's surfaces"});
    key("most_inside", c.most_inside,
        {0, 1, "", "of the returns, that may stand where the scan before saw nothing"});
    key("recovery_turn_deg", c.recovery_turn_rad,
        {0, 180, rt::kDegInRad, "a lost robot is looked for this far either way"});
    key("recovery_move_m", c.recovery_move_m, {0, 10, "m", "a lost robot is looked for this far"});
    key("planar", c.planar,
        {"for a lidar of one row: x, y and yaw are matched, height and tilt stay the odometry's"});
  }
};

/// How much of a map is held. The window is about the sensor: what lies beyond it is given back.
struct RegistrationMemory {
  std::uint32_t surfels{32'768};      ///< of the finest layer; half of it and a quarter of the others
  std::uint32_t window_cells{128};    ///< of the finest layer, along x and along y; a power of two
  std::uint32_t window_cells_up{32};  ///< along z

  SORTIE_KEYS(c, key) {
    key("limits.surfels", c.surfels,
        {256, kMostSurfels, "surfels", "of the finest layer of the map of surfaces"});
    key("window_cells", c.window_cells,
        {16, 1024, "cells", "of the map along x and y, a power of two; a kept map fits into half of it"});
    key("window_cells_up", c.window_cells_up, {8, 256, "cells", "the same upwards"});
  }
  static constexpr std::uint32_t kMostSurfels = 1u << 20;
};

}  // namespace sortie::mapping
