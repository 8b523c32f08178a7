// SPDX-License-Identifier: BSD-3-Clause
// Builds the hall of simulated missions: walls with doors, a partition, pillars, a ramp and furniture.
#pragma once

#include <cstdint>

#include "hil/world.hpp"

namespace sortie::hil {

/// A point of the plan view, metres.
struct PlanPoint {
  double x_m{};
  double y_m{};
};

/// What the hall looks like, in metres. World frame: the robot starts at the origin, heading along x.
struct HallConfig {
  static constexpr std::uint32_t kMaxPath = 16;

  double length_m{20.0};  ///< inner size along x
  double width_m{14.0};   ///< inner size along y, the hall is centred on y = 0
  double height_m{3.0};   ///< of the walls; there is no ceiling
  double west_x_m{-3.0};  ///< x of the inner face of the west wall
  double wall_m{0.2};     ///< thickness of all walls

  double door_width_m{1.6};   ///< of every opening
  double door_height_m{2.1};  ///< the wall goes on above it
  bool outer_doors{true};     ///< one opening in the middle of the north and the south wall

  double partition_x_m{11.0};      ///< a wall across with two openings; outside of the hall: no partition
  double partition_door_y_m{4.0};  ///< the openings are centred on +- this

  std::uint32_t pillars{8};  ///< in two rows along the hall; an odd count of columns stands before the doors
  double pillar_radius_m{0.2};
  double pillar_row_y_m{5.6};  ///< the rows stand at +- this

  double ramp_height_m{0.25};  ///< a ramp up, a flat piece and a ramp down across the path; 0: none
  double ramp_length_m{1.5};   ///< of each slope, along x
  double ramp_flat_m{1.2};
  double ramp_width_m{2.0};
  double ramp_x_m{5.0};  ///< centre of the flat piece
  double ramp_y_m{0.0};

  std::uint32_t furniture{40};  ///< crates, barrels, shelves, tables; what does not fit is left out
  std::uint64_t seed{1};        ///< of the furniture; a report must print it

  /// The way that is kept free of furniture: a closed or open polyline.
  PlanPoint path_m[kMaxPath]{{0, 0}, {9.3, 0}, {9.3, 4}, {14, 4}, {14, -4}, {9.3, -4}, {0, -4}, {0, 0}};
  std::uint32_t path_points{8};
  double path_clearance_m{0.8};  ///< furniture keeps this distance from the polyline
};

/// What was built.
struct HallReport {
  std::uint64_t seed{};
  std::uint32_t solids{};
  std::uint32_t furniture_placed{};
  std::uint32_t furniture_left_out{};  ///< no free place was found for them
};

/// Adds the hall to an empty world and finalizes it. The same config gives the same hall everywhere. Set-up
/// code: throws std::runtime_error with the setting to change if the config is not buildable.
HallReport build_hall(const HallConfig& config, World& world);

/// Tries config.furniture pieces at random places of the hall and adds those that keep their distance from
/// the path and from what is already there. Leaves the world unfinalized and `solids` of the report 0.
HallReport add_furniture(const HallConfig& config, World& world);

/// Distance in metres from a point to the polyline that is kept free; infinity if there is none.
double distance_to_path(const HallConfig& config, double x_m, double y_m);

}  // namespace sortie::hil
