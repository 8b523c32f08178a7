// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/uav_config.hpp"

#include <cmath>
#include <stdexcept>

#include "firmware_like/parts/world_boxes.hpp"
#include "firmware_like/scene/units.hpp"
#include "mapping/occupancy/occupancy.hpp"

namespace sortie::firmware {

namespace {

// The AscTec Neo with propellers of 11 inches, as RotorS' controllers know it.
planner::UavModel read_airframe(Profile& profile) {
  planner::UavModel model;
  const auto number = [&profile](const char* path, double fallback, double low, double high, const char* unit,
                                 const char* meaning) {
    return profile.number(path, {fallback, low, high, unit, meaning});
  };
  const char* inertia = "moment of inertia of the whole vehicle";
  model.mass_kg = number("airframe.mass_kg", 3.42, 0.05, 50, "kg", "of the whole vehicle");
  model.inertia_kg_m2 = {number("airframe.inertia_xx_kg_m2", 0.0608, 1e-5, 50, "kg m2", inertia),
                         number("airframe.inertia_yy_kg_m2", 0.0688, 1e-5, 50, "kg m2", inertia),
                         number("airframe.inertia_zz_kg_m2", 0.1489, 1e-5, 50, "kg m2", inertia)};
  const auto rotors = static_cast<std::uint32_t>(profile.integer(
      "airframe.rotors", {6, 4, rt::kMaxRotors, "", "in a regular ring, turning by turns left and right"}));
  const double arm_m = number("airframe.arm_m", 0.2895, 0.02, 3, "m", "from the middle to a rotor");
  const double first_deg = number("airframe.first_rotor_deg", 30, -360, 360, "deg",
                                  "of rotor 1, from ahead to the left; it turns left");
  planner::place_rotors(model, rotors, arm_m, first_deg * kDegree);
  model.thrust_n_s2 =
      number("airframe.thrust_n_s2", 1.269e-5, 1e-9, 1, "N s2", "thrust / square of the speed");
  model.moment_m = number("airframe.moment_m", 0.016754, 1e-6, 1, "m", "yaw torque / thrust");
  model.tau_up_s =
      1e-3 * number("airframe.tau_up_ms", 18.2, 0.01, 500, "ms", "lag of a rotor that speeds up");
  model.tau_down_s =
      1e-3 * number("airframe.tau_down_ms", 18.2, 0.01, 500, "ms", "lag of a rotor that slows down");
  model.max_speed_rad_s =
      number("airframe.max_rotor_rad_s", 1047.2, 10, 1310, "rad/s", "most that a rotor is asked for");
  if (planner::check(model) != Status::ok)
    profile.fail("airframe.mass_kg", "the rotors cannot lift that: more weight than thrust");
  return model;
}

void read_flight(Profile& profile, planner::UavPilotConfig& pilot) {
  planner::UavControlConfig& control = pilot.control;
  const auto number = [&profile](const char* path, double fallback, double low, double high, const char* unit,
                                 const char* meaning) {
    return profile.number(path, {fallback, low, high, unit, meaning});
  };
  planner::ProfileLimits& limits = control.profile;
  limits.speed_m_s = number("flight.speed_m_s", limits.speed_m_s, 0.05, 10, "m/s", "most, across");
  limits.climb_m_s = number("flight.climb_m_s", limits.climb_m_s, 0.05, 5, "m/s", "most, up and down");
  limits.acceleration_m_s2 =
      number("flight.acceleration_m_s2", limits.acceleration_m_s2, 0.1, 10, "m/s2", "most of a goal's way");
  limits.turn_rad_s = number("flight.turn_rad_s", limits.turn_rad_s, 0.05, 6, "rad/s", "most of the heading");
  control.max_tilt_rad =
      kDegree * number("flight.max_tilt_deg", 35, 5, 60, "deg", "of the attitude that is asked for");
  control.sink_m_s = number("flight.sink_m_s", control.sink_m_s, 0.1, 2, "m/s", "of a landing");
  pilot.take_off_m =
      number("flight.take_off_m", pilot.take_off_m, 0.3, 50, "m", "straight up, before all else");
  pilot.reach_m = number("flight.reach_m", pilot.reach_m, 0.005, 5, "m", "so near to a goal counts as there");
  pilot.ask_again_ns =
      milliseconds(1e3 * number("flight.ask_again_s", 1, 0.1, 1000, "s", "after there was no way to a goal"));
  pilot.start_wait_ns =
      milliseconds(1e3 * number("mission.start_s", 0, 0, 3600, "s", "the vehicle stands this long"));
  pilot.lands = profile.flag("mission.land", false, "after the last goal it lands where it is");
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
  read_flight(profile, config);
  return config;
}

estimators::UavEstimatorConfig read_uav_estimator_config(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  estimators::UavEstimatorConfig config;
  const auto number = [&profile](const char* path, double fallback, double low, double high, const char* unit,
                                 const char* meaning) {
    return profile.number(path, {fallback, low, high, unit, meaning});
  };
  config.fix_sigma_m = number("state.fix_sigma_m", config.fix_sigma_m, 1e-4, 10, "m", "of a fix, each axis");
  config.fix_yaw_sigma_rad =
      number("state.fix_yaw_sigma_rad", config.fix_yaw_sigma_rad, 1e-4, 1, "rad", "of a fix's heading");
  config.noise.gyr_rad_s_rt_hz = number("state.gyr_noise_rad_s_rt_hz", config.noise.gyr_rad_s_rt_hz, 1e-6, 1,
                                        "rad/s/rtHz", "density that the filter reckons with");
  config.noise.acc_m_s2_rt_hz = number("state.acc_noise_m_s2_rt_hz", config.noise.acc_m_s2_rt_hz, 1e-5, 10,
                                       "m/s2/rtHz", "density that the filter reckons with");
  const char* arm = "where the IMU sits, from the body's origin";
  config.p_body_imu_m = {number("imu.x_m", 0, -10, 10, "m", arm), number("imu.y_m", 0, -10, 10, "m", arm),
                         number("imu.z_m", 0, -10, 10, "m", arm)};
  config.dead_after_s = number("state.dead_after_s", config.dead_after_s, 0.05, 10, "s",
                               "without a fix: dead reckoning, it hovers");
  config.lost_after_s =
      number("state.lost_after_s", config.lost_after_s, 0.1, 60, "s", "without a fix: lost, it sinks level");
  if (config.lost_after_s <= config.dead_after_s)
    profile.fail("state.lost_after_s", "must be above state.dead_after_s");
  config.lost_sigma_m = number("state.lost_sigma_m", config.lost_sigma_m, 0.05, 100, "m",
                               "also lost: standard deviation of the worst axis");
  config.disturbance.across_hz = number("state.disturbance_hz", config.disturbance.across_hz, 0.1, 50, "Hz",
                                        "bandwidth of the observed wind, square to the rotors' axis");
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
  const auto number = [&profile](const char* path, double fallback, double low, double high,
                                 const char* meaning) {
    return profile.number(path, {fallback, low, high, "m", meaning});
  };
  config.map.voxel_m = number("flight_map.voxel_m", 0.2, 0.05, 2, "edge of a voxel");
  const char* origin = "lowest corner of the map";
  config.map.origin_m = {number("flight_map.x_m", -2, -4000, 4000, origin),
                         number("flight_map.y_m", -4, -4000, 4000, origin),
                         number("flight_map.z_m", 0, -4000, 4000, origin)};
  const auto voxels = [&](const char* path, double fallback) {
    const double length = number(path, fallback, 0.4, 2000, "extent of the map; whole blocks of four voxels");
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
  const auto pool = [&profile](const char* path, double fallback, double least, const char* meaning) {
    return static_cast<std::uint32_t>(profile.integer(path, {fallback, least, 1 << 20, "", meaning}));
  };
  config.parts = pool("limits.path_parts", 16'384, 256, "connected parts of blocks that a search may meet");
  config.voxels = pool("limits.path_voxels", 16'384, 256, "of the fine search; a power of two");
  config.corners =
      pool("limits.path_corners", 4096, planner::CornerMemory::kFewest, "of a way before it is shortened");
  if ((config.voxels & (config.voxels - 1)) != 0)
    profile.fail("limits.path_voxels", "must be a power of two");
  if (planner::FlightMap::bricks_for(config.map) == 0)
    profile.fail("flight_map.length_m", "no side may have more than 1024 voxels");
  return config;
}

}  // namespace sortie::firmware
