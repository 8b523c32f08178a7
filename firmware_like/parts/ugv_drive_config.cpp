// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_drive_config.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {

DriveSetup read_drive_setup(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  DriveSetup setup;
  planner::UgvDriveConfig& config = setup.config;
  // The limiter steps with the group; the builder has checked that the rate is a whole number of ticks.
  const double rate_hz =
      profile.number("groups.control.rate_hz", {1000, 0.01, 1e5, "Hz", "releases a second"});
  config.step_ns = std::llround(1e9 / rate_hz);
  config.max_track_m_s = 0.8;
  config.guard.max_roll_rad = 40 * kDegree;
  config.guard.max_pitch_rad = 45 * kDegree;
  config.guard.tilt_hysteresis_rad = 5 * kDegree;
  profile.read("drive", setup);
  config.icr = setup.icr.model();
  if (config.stop.acceleration < config.ramps.speed.acceleration)
    profile.fail("drive.stop_deceleration_m_s2", "must not be below drive.max_acceleration_m_s2");
  if (config.stop.jerk < config.ramps.speed.jerk)
    profile.fail("drive.stop_jerk_m_s3", "must not be below drive.max_jerk_m_s3");
  return setup;
}

FlipperSetup read_flipper_setup(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  FlipperSetup setup;
  setup.names = profile.texts("flippers.postures", {}, "names of the postures; each needs a NAME_deg");
  if (setup.names.empty())
    profile.fail("flippers.postures", "a robot with flippers needs one posture at least");
  if (setup.names.size() > planner::FlipperPostures::kMaxPostures)
    profile.fail("flippers.postures",
                 "at most " + std::to_string(planner::FlipperPostures::kMaxPostures) + " fit");
  for (const std::string& name : setup.names) {
    const std::string path = "flippers." + name + "_deg";
    if (std::count(setup.names.begin(), setup.names.end(), name) != 1)
      profile.fail("flippers.postures", "\"" + name + "\" stands there twice");
    if (!profile.has(path)) profile.fail("flippers.postures", name + " needs " + path + " = [4 angles]");
    const std::vector<double> angles =
        profile.numbers(path, std::vector<double>(rt::kFlippers, 0.0),
                        {0, -360, 360, "deg",
                         "front left, front right, rear left, rear right; 0 stretched out, tip up positive"});
    planner::FlipperPosture& posture = setup.postures.emplace_back();
    for (std::size_t i = 0; i < rt::kFlippers; ++i) posture.angle_rad[i] = kDegree * angles[i];
  }
  const std::string initial =
      profile.text("flippers.initial", setup.names.front(), "posture at the start", setup.names);
  setup.config.initial = static_cast<std::uint32_t>(
      std::find(setup.names.begin(), setup.names.end(), initial) - setup.names.begin());
  setup.config.rate_rad_s = 45 * kDegree;
  setup.config.tolerance_rad = 3 * kDegree;
  profile.read("flippers", setup.config);
  return setup;
}

std::vector<planner::Waypoint> read_route(VehicleBuilder& builder) {
  std::vector<planner::Waypoint> route;
  for (const auto& point : builder.profile().points(
           "mission.waypoints", planner::WaypointFollower::kMaxWaypoints, "way to drive, in order")) {
    route.push_back({point[0], point[1]});
  }
  return route;
}

std::vector<planner::MissionStep> read_mission(VehicleBuilder& builder,
                                               const std::vector<std::string>& postures) {
  Profile& profile = builder.profile();
  using Kind = ColumnSpec::Kind;
  const std::vector<ColumnSpec> columns = {
      {"at_s", Kind::number, {0, 0, 1e7, "s"}, true},
      {"speed_m_s", Kind::number, {0, -planner::kMostAskedSpeed_m_s, planner::kMostAskedSpeed_m_s, "m/s"}},
      {"turn_rad_s",
       Kind::number,
       {0, -planner::kMostAskedTurn_rad_s, planner::kMostAskedTurn_rad_s, "rad/s"}},
      {"posture", Kind::text, {}},
      {"route", Kind::flag, {}},
  };
  std::vector<planner::MissionStep> steps;
  double before_s = -1;
  for (const ProfileRow& row : profile.rows(
           "mission.commands", columns, planner::Mission::kMaxSteps,
           "what to do from which time on: a speed and a turn rate, or the route; without any, the route")) {
    planner::MissionStep& step = steps.emplace_back();
    const double at_s = row.numbers.at("at_s");
    if (at_s <= before_s) profile.fail(row.path, "at_s must rise from row to row");
    before_s = at_s;
    step.at_ns = milliseconds(1e3 * at_s);
    step.speed_m_s = row.numbers.at("speed_m_s");
    step.turn_rad_s = row.numbers.at("turn_rad_s");
    step.route = row.numbers.at("route") != 0.0;
    if (step.route && (step.speed_m_s != 0.0 || step.turn_rad_s != 0.0))
      profile.fail(row.path, "has either route = true, or a speed and a turn rate");
    if (const auto posture = row.texts.find("posture"); posture != row.texts.end()) {
      const auto found = std::find(postures.begin(), postures.end(), posture->second);
      if (found == postures.end())
        profile.fail(row.path, "no posture \"" + posture->second + "\"; see [flippers] postures");
      step.posture = static_cast<std::int32_t>(found - postures.begin());
    }
  }
  if (!steps.empty() && (steps.back().speed_m_s != 0.0 || steps.back().turn_rad_s != 0.0))
    profile.fail("mission.commands", "the last row must not leave the robot moving for good");
  return steps;
}

}  // namespace sortie::firmware
