// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/uav_config.hpp"

#include <cmath>
#include <stdexcept>

#include "firmware_like/parts/world_boxes.hpp"
#include "firmware_like/scene/units.hpp"
#include "mapping/occupancy/occupancy.hpp"

namespace sortie::firmware {

namespace {

planner::UavModel read_airframe(Profile& profile) {
  planner::RegularMultirotor airframe;
  profile.read("airframe", airframe);
  planner::UavModel& model = airframe.model;
  planner::place_rotors(model, model.rotors, airframe.arm_m, airframe.first_rad);
  if (planner::check(model) != Status::ok)
    profile.fail("airframe.mass_kg", "the rotors cannot lift that: more weight than thrust");
  return model;
}

}  // namespace

planner::UavPilotConfig read_pilot_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  planner::UavPilotConfig config;
  // The gains are designed for the group's period; the builder has checked that it is whole.
  const double rate_hz =
      profile.number("groups.control.rate_hz", {200, 0.01, 1e5, "Hz", "releases a second"});
  if (rate_hz < 10 || rate_hz > 1000) profile.fail("groups.control.rate_hz", "must lie in 10 .. 1000 Hz");
  config.control.period_s = 1.0 / rate_hz;
  config.control.model = read_airframe(profile);
  config.control.max_tilt_rad = 35 * kDegree;
  profile.read("flight", config);
  return config;
}

estimators::UavEstimatorConfig read_uav_estimator_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  profile.knob("groups.control.rate_hz");
  estimators::UavEstimatorConfig config;
  profile.read("state", config);
  if (config.lost_after_s <= config.dead_after_s)
    profile.fail("state.lost_after_s", "must be above state.dead_after_s");
  return config;
}

std::vector<planner::UavGoal> read_uav_mission(VehicleBuilder& builder) {
  using Kind = ColumnSpec::Kind;
  const std::vector<ColumnSpec> columns = {
      {"x_m", Kind::number, {0, -4000, 4000, "m"}, true}, {"y_m", Kind::number, {0, -4000, 4000, "m"}, true},
      {"z_m", Kind::number, {1, -4000, 4000, "m"}, true}, {"yaw_deg", Kind::number, {0, -360, 360, "deg"}},
      {"wait_s", Kind::number, {0, 0, 3600, "s"}},
  };
  std::vector<planner::UavGoal> goals;
  for (const ProfileRow& row : builder.profile().rows("mission.goals", columns, planner::UavPilot::kMostGoals,
                                                      "places to fly to, in order")) {
    goals.push_back({{row.numbers.at("x_m"), row.numbers.at("y_m"), row.numbers.at("z_m")},
                     kDegree * row.numbers.at("yaw_deg"),
                     milliseconds(1e3 * row.numbers.at("wait_s"))});
  }
  return goals;
}

std::vector<planner::UavGoal> read_uav_looks(VehicleBuilder& builder) {
  using Kind = ColumnSpec::Kind;
  const std::vector<ColumnSpec> columns = {
      {"z_m", Kind::number, {1, 0.3, 50, "m"}, true},
      {"yaw_deg", Kind::number, {0, -360, 360, "deg"}},
      {"wait_s", Kind::number, {0, 0, 3600, "s"}},
  };
  std::vector<planner::UavGoal> looks;
  for (const ProfileRow& row : builder.profile().rows(
           "mission.looks", columns, planner::UavPilot::kMostLooks,
           "heights over the start and headings, round and round, until part join has found "
           "the vehicle's place")) {
    looks.push_back({{0, 0, row.numbers.at("z_m")},
                     kDegree * row.numbers.at("yaw_deg"),
                     milliseconds(1e3 * row.numbers.at("wait_s"))});
  }
  return looks;
}

namespace {

// Voxels are cells of an occupancy map: its corner lies on a corner of a cell.
void align(GuideConfig& config) {
  const double voxel_m = config.map.voxel_m;
  double* const origin[3] = {&config.map.origin_m.x, &config.map.origin_m.y, &config.map.origin_m.z};
  for (int a = 0; a < 3; ++a) {
    const double cell = std::round(*origin[a] / voxel_m);
    config.cells.low[a] = static_cast<std::int32_t>(cell);
    *origin[a] = voxel_m * cell;
  }
}

void read_limits(Profile& profile, GuideConfig& config) {
  config.cells.free_code = mapping::OccupancyMap::code_of(profile.number(
      "flight_map.free_below", {0.05, 0.001, 0.5, "", "chance of a cell that may be entered"}));
  config.cells.blocked_code = mapping::OccupancyMap::code_of(
      profile.number("flight_map.blocked_above",
                     {0.5, 0.01, 0.999, "", "chance of a cell that is blocked; between: as it was"}));
  if (config.cells.blocked_code < config.cells.free_code)
    profile.fail("flight_map.blocked_above", "must not be below flight_map.free_below");
}

void read_known(Profile& profile, bool stored, GuideConfig& config) {
  const std::string text = profile.text("flight_map.cells", "",
                                        "what another run knows of the map, from `sortie export flight_map`");
  if (text.empty() && stored) {
    profile.fail("flight_map.source",
                 "\"stored\" needs flight_map.cells; `sortie export flight_map LOG --for " + profile.name() +
                     " -o FILE` writes a scene that has them");
  }
  if (text.empty()) return;
  const planner::FlightMapConfig& map = config.map;
  const auto voxels = std::size_t(map.nx) * std::size_t(map.ny) * std::size_t(map.nz);
  try {
    config.known = unpack_cells(text, voxels);
  } catch (const std::invalid_argument& error) {
    profile.fail("flight_map.cells", error.what());
  }
}

// Where the map's voxels are.
GuideConfig read_voxels(Profile& profile) {
  GuideConfig config;
  config.map.origin_m = {-2, -4, 0};
  profile.read("flight_map", config.map);
  const auto voxels = [&](const char* path, double fallback) {
    const double length =
        profile.number(path, {fallback, 0.4, 2000, "m", "extent of the map; whole blocks of four voxels"});
    return static_cast<std::int32_t>(4.0 * std::ceil(length / (4.0 * config.map.voxel_m) - 1e-9));
  };
  config.map.nx = voxels("flight_map.length_m", 24);
  config.map.ny = voxels("flight_map.width_m", 8);
  config.map.nz = voxels("flight_map.height_m", 3.2);
  return config;
}

}  // namespace

GuideConfig read_flight_voxels(Profile& profile) {
  GuideConfig config = read_voxels(profile);
  align(config);
  read_limits(profile, config);
  return config;
}

GuideConfig read_guide_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  GuideConfig config = read_voxels(profile);
  const auto number = [&profile](const char* path, double fallback, double low, double high,
                                 const char* meaning) {
    return profile.number(path, {fallback, low, high, "m", meaning});
  };
  const double radius =
      number("airframe.radius_m", 0.45, 0.05, 3, "of all of it from above, with propellers");
  const double half = number("airframe.half_height_m", 0.15, 0.02, 3, "of all of it from the side");
  config.map.radii_m = {radius, radius, half};
  const std::string source =
      profile.text("flight_map.source", "given",
                   "given: [[world.boxes]] are known, the rest is air; lidar: what was not seen is not flown "
                   "through; stored: what flight_map.cells does not call free is not",
                   {"given", "lidar", "stored"});
  const bool given = source == "given";
  config.sensed = source == "lidar";
  config.map.unknown_is_blocked = !given;
  const double margin = number("flight_map.margin_m", 0, 0, 2, "kept beyond the vehicle's own size");
  config.map.radii_m = config.map.radii_m + rt::Vector3{margin, margin, margin};
  if (!given) {
    align(config);
    read_limits(profile, config);
    config.bubble_m = profile.number(
        "flight_map.bubble_m",
        {0.3, 0, 2, "m", "room around the vehicle that is free until its first question, seen or not"});
    if (planner::FlightMap::bricks_for(config.map) != 0) read_known(profile, source == "stored", config);
  }
  for (const WorldBox& box : read_world_boxes(profile)) {
    if (given)
      config.boxes.push_back({rt::to_vector(box.lowest_m), rt::to_vector(box.highest_m), box.from_ns});
  }
  profile.read("limits", config);
  profile.check_power_of_two("limits.path_voxels", config.voxels);
  if (planner::FlightMap::bricks_for(config.map) == 0)
    profile.fail("flight_map.length_m", "no side may have more than 1024 voxels");
  return config;
}

}  // namespace sortie::firmware
