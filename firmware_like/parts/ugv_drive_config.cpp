// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/parts/ugv_drive_config.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/units.hpp"

namespace sortie::firmware {

namespace {

void read_ramps(Profile& profile, planner::UgvDriveConfig& config) {
  planner::TwistRamps& ramps = config.ramps;
  ramps.speed.acceleration =
      profile.number("drive.max_acceleration_m_s2",
                     {ramps.speed.acceleration, 0.01, 20, "m/s2", "of the body along its way"});
  ramps.speed.jerk = profile.number("drive.max_jerk_m_s3",
                                    {ramps.speed.jerk, 0.01, 1000, "m/s3", "how fast that builds up"});
  ramps.turn.acceleration = profile.number("drive.max_turn_acceleration_rad_s2",
                                           {ramps.turn.acceleration, 0.01, 100, "rad/s2", "of the body"});
  ramps.turn.jerk = profile.number("drive.max_turn_jerk_rad_s3",
                                   {ramps.turn.jerk, 0.01, 10'000, "rad/s3", "how fast that builds up"});
  config.stop.acceleration =
      profile.number("drive.stop_deceleration_m_s2",
                     {config.stop.acceleration, 0.01, 20, "m/s2",
                      "of every stop; turning stops by as much more firmly than it usually slows down"});
  config.stop.jerk =
      profile.number("drive.stop_jerk_m_s3",
                     {config.stop.jerk, 0.01, 1000, "m/s3", "how fast the deceleration of a stop builds up"});
  if (config.stop.acceleration < ramps.speed.acceleration)
    profile.fail("drive.stop_deceleration_m_s2", "must not be below drive.max_acceleration_m_s2");
  if (config.stop.jerk < ramps.speed.jerk)
    profile.fail("drive.stop_jerk_m_s3", "must not be below drive.max_jerk_m_s3");
}

void read_guard(Profile& profile, planner::DriveGuardConfig& guard) {
  guard.max_pose_age_ns =
      milliseconds(profile.number("drive.max_pose_age_ms", {in_ms(guard.max_pose_age_ns), 1, 1e4, "ms",
                                                            "with an older pose the robot stops"}));
  guard.max_roll_rad =
      kDegree * profile.number("drive.max_roll_deg", {40, 1, 180, "deg", "tilted further the robot stops"});
  guard.max_pitch_rad =
      kDegree * profile.number("drive.max_pitch_deg", {45, 1, 90, "deg", "tilted further the robot stops"});
  guard.tilt_hysteresis_rad =
      kDegree * profile.number("drive.tilt_hysteresis_deg",
                               {5, 0, 90, "deg", "it goes on when both are so far below their limits"});
  guard.resume_ns = milliseconds(profile.number(
      "drive.resume_ms",
      {in_ms(guard.resume_ns), 0, 1e5, "ms", "after a stop: at rest and without any reason for so long"}));
}

void read_follower(Profile& profile, planner::WaypointFollowerConfig& follower) {
  follower.reach_radius_m = profile.number(
      "drive.reach_m", {follower.reach_radius_m, 0.01, 10, "m", "a waypoint this near counts as reached"});
  follower.creep_speed_m_s = profile.number(
      "drive.creep_speed_m_s", {follower.creep_speed_m_s, 0.001, 1, "m/s", "least speed on the way"});
  follower.reverse_m = profile.number(
      "drive.reverse_m",
      {follower.reverse_m, 0, 1000, "m", "a waypoint behind and nearer than this is driven to in reverse"});
  follower.stuck_s = profile.number(
      "drive.stuck_s", {follower.stuck_s, 0, 3600, "s", "so long without progress is stuck; 0: never"});
  follower.stuck_tries = static_cast<std::uint32_t>(
      profile.integer("drive.stuck_tries", {static_cast<double>(follower.stuck_tries), 0, 1000, "",
                                            "times it backs off and tries again, for each waypoint"}));
  follower.back_off_m = profile.number(
      "drive.back_off_m", {follower.back_off_m, 0, 10, "m", "how far it drives back when it is stuck"});
  follower.repeat = profile.flag("mission.repeat", false, "after the last waypoint comes the first");
}

}  // namespace

DriveSetup read_drive_setup(VehicleBuilder& builder) {
  Profile& profile = builder.profile();
  DriveSetup setup;
  planner::UgvDriveConfig& config = setup.config;
  // The limiter steps with the group; the builder has checked that the rate is a whole number of ticks.
  const double rate_hz =
      profile.number("groups.control.rate_hz", {1000, 0.01, 1e5, "Hz", "releases a second"});
  config.step_ns = std::llround(1e9 / rate_hz);
  const double width = profile.number(
      "drive.track_width_m",
      {0.4, 0.05, 10, "m", "distance of the tracks, or of their turning centres with efficiency 1"});
  setup.efficiency =
      profile.number("drive.steering_efficiency",
                     {1, 0.05, 1, "", "distance of the tracks / distance of their turning centres"});
  const double x = profile.number("drive.turning_centre_x_m",
                                  {0, -10, 10, "m", "forward place of the body's turning centre"});
  const double y =
      profile.number("drive.turning_centre_y_m",
                     {0, -0.02, 0.02, "m", "middle of the tracks' turning centres, to the left"});
  config.icr = planner::IcrModel::from_efficiency(width, setup.efficiency, x, y);
  config.max_speed_m_s = profile.number("drive.max_speed_m_s",
                                        {config.max_speed_m_s, 0.01, 10, "m/s", "of the body along its way"});
  config.max_turn_rad_s =
      profile.number("drive.max_turn_rate_rad_s", {config.max_turn_rad_s, 0.01, 10, "rad/s", "of the body"});
  config.max_track_m_s = profile.number(
      "drive.max_track_speed_m_s",
      {0.8, 0.01, 20, "m/s", "of either belt; what needs more is driven slower on the same curve"});
  read_ramps(profile, config);
  read_guard(profile, config.guard);
  read_follower(profile, config.follower);
  config.start_wait_ns = milliseconds(
      1e3 * profile.number("mission.start_s", {0, 0, 3600, "s", "the robot stands still this long"}));
  setup.remote = profile.flag("drive.remote", false, "requests over LCM may drive the robot");
  if (setup.remote) {
    config.start_halted = profile.flag("drive.start_halted", false,
                                       "begins in a halt: nothing moves before a request says release");
    config.max_command_age_ns = milliseconds(profile.number(
        "drive.max_command_age_ms", {in_ms(config.max_command_age_ns), 10, 1e5, "ms",
                                     "who is in control and silent for so long makes the robot stop"}));
    config.recover_speed_m_s = profile.number(
        "drive.recover_speed_m_s",
        {config.recover_speed_m_s, 0.01, 1, "m/s", "most speed of a belt that drives a tilted robot off"});
  }
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
  setup.config.rate_rad_s =
      kDegree * profile.number("flippers.rate_deg_s",
                               {45, 0.1, 1000, "deg/s", "of the flipper that has the longest way"});
  setup.config.tolerance_rad =
      kDegree *
      profile.number("flippers.tolerance_deg", {3, 0, 90, "deg", "a measured angle this near is there"});
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
