// SPDX-License-Identifier: BSD-3-Clause
// The fixed parts of the hall: walls, partition, pillars and the ramp. Furniture is in hall_furniture.cpp.
#include "hil/hall.hpp"

#include <stdexcept>
#include <string>

namespace sortie::hil {
namespace {

constexpr std::uint16_t kWallReflectivity = 180;
constexpr std::uint16_t kPillarReflectivity = 140;
constexpr std::uint16_t kRampReflectivity = 90;

void must_add(World& world, const Solid& solid, const char* what) {
  const Status status = world.add(solid);
  if (status == Status::ok) return;
  throw std::runtime_error(std::string("hil hall: cannot add ") + what + ": " + to_string(status) +
                           "; check its size in the [hil] settings, or ask for less furniture");
}

/// A straight wall between two coordinates of one axis, with openings centred on some of them.
struct Wall {
  bool along_x;
  double fixed_m;  ///< centre of the wall on the other axis
  double from_m;
  double to_m;
};

void add_piece(World& world, const HallConfig& config, const Wall& wall, double from, double to,
               double bottom) {
  if (to - from < 1e-3) return;
  BoxShape shape;
  shape.center_x_m = wall.along_x ? 0.5 * (from + to) : wall.fixed_m;
  shape.center_y_m = wall.along_x ? wall.fixed_m : 0.5 * (from + to);
  shape.length_m = wall.along_x ? to - from : config.wall_m;
  shape.width_m = wall.along_x ? config.wall_m : to - from;
  shape.bottom_m = bottom;
  shape.top_m = config.height_m;
  must_add(world, make_box(shape, kWallReflectivity), "a wall");
}

void add_wall(World& world, const HallConfig& config, const Wall& wall, const double* doors, int count) {
  double from = wall.from_m;
  for (int i = 0; i < count; ++i) {
    const double left = doors[i] - 0.5 * config.door_width_m;
    const double right = doors[i] + 0.5 * config.door_width_m;
    if (left < from || right > wall.to_m) {
      throw std::runtime_error(
          "hil hall: a door does not fit into its wall; make the hall larger or door_width_m smaller");
    }
    add_piece(world, config, wall, from, left, 0.0);
    if (config.door_height_m < config.height_m) {
      add_piece(world, config, wall, left, right, config.door_height_m);
    }
    from = right;
  }
  add_piece(world, config, wall, from, wall.to_m, 0.0);
}

void add_walls(World& world, const HallConfig& config) {
  const double half_wall = 0.5 * config.wall_m;
  const double half_width = 0.5 * config.width_m;
  const double west = config.west_x_m;
  const double east = west + config.length_m;
  const double middle[] = {0.5 * (west + east)};
  const int doors = config.outer_doors ? 1 : 0;
  add_wall(world, config, {true, half_width + half_wall, west - config.wall_m, east + config.wall_m}, middle,
           doors);
  add_wall(world, config, {true, -half_width - half_wall, west - config.wall_m, east + config.wall_m}, middle,
           doors);
  add_wall(world, config, {false, west - half_wall, -half_width, half_width}, nullptr, 0);
  add_wall(world, config, {false, east + half_wall, -half_width, half_width}, nullptr, 0);
  if (config.partition_x_m > west && config.partition_x_m < east) {
    const double openings[] = {-config.partition_door_y_m, config.partition_door_y_m};
    add_wall(world, config, {false, config.partition_x_m, -half_width, half_width}, openings, 2);
  }
}

void add_pillars(World& world, const HallConfig& config) {
  const std::uint32_t columns = (config.pillars + 1) / 2;
  for (std::uint32_t i = 0; i < config.pillars; ++i) {
    const std::uint32_t column = i / 2;
    const double share = (static_cast<double>(column) + 0.5) / static_cast<double>(columns);
    const double y = (i % 2 == 0 ? 1.0 : -1.0) * config.pillar_row_y_m;
    must_add(world,
             make_cylinder(config.west_x_m + share * config.length_m, y, config.pillar_radius_m, 0.0,
                           config.height_m, kPillarReflectivity),
             "a pillar");
  }
}

void add_ramp(World& world, const HallConfig& config) {
  if (!(config.ramp_height_m > 0.0)) return;
  const double reach = 0.5 * (config.ramp_flat_m + config.ramp_length_m);
  // The flat piece reaches 1 mm over each slope: rounding must not leave a gap that a track falls into.
  const double flat_m = config.ramp_flat_m + 0.002;
  const BoxShape flat{config.ramp_x_m,     config.ramp_y_m, 0.0, flat_m, config.ramp_width_m, 0.0,
                      config.ramp_height_m};
  must_add(world, make_box(flat, kRampReflectivity, true), "the ramp");
  BoxShape slope = flat;
  slope.length_m = config.ramp_length_m;
  slope.center_x_m = config.ramp_x_m - reach;
  must_add(world, make_wedge(slope, kRampReflectivity), "the ramp");
  slope.center_x_m = config.ramp_x_m + reach;
  slope.yaw_rad = 3.14159265358979323846;
  must_add(world, make_wedge(slope, kRampReflectivity), "the ramp");
}

}  // namespace

HallReport build_hall(const HallConfig& config, World& world) {
  if (config.path_points > HallConfig::kMaxPath) {
    throw std::runtime_error("hil hall: the free path has too many points; the limit is " +
                             std::to_string(HallConfig::kMaxPath));
  }
  add_walls(world, config);
  add_pillars(world, config);
  add_ramp(world, config);
  HallReport report = add_furniture(config, world);
  const Status status = world.finalize();
  if (status != Status::ok) {
    throw std::runtime_error("hil hall: the broad phase is full; ask for less furniture or a smaller hall");
  }
  report.solids = static_cast<std::uint32_t>(world.size());
  return report;
}

}  // namespace sortie::hil
