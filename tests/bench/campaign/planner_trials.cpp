// SPDX-License-Identifier: BSD-3-Clause
// Planners and controllers under the campaign: ways, drive limits and waypoints, flight controller, Riccati
// equation.
#include <algorithm>
#include <cmath>
#include <memory>

#include "hil/uav/multirotor_config.hpp"
#include "hil/uav/multirotor_dynamics.hpp"
#include "planner/twist_limiter.hpp"
#include "planner/uav_control/dare.hpp"
#include "planner/uav_control/double_double.hpp"
#include "planner/uav_control/uav_control.hpp"
#include "planner/waypoint_follower.hpp"
#include "tests/bench/campaign/trial.hpp"
#include "tests/bench/campaign/trials.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::bench {

namespace {

planner::UavModel plain_hexacopter() {
  planner::UavModel model;
  const hil::MultirotorConfig plant = hil::firefly_plant();
  model.mass_kg = hil::total_mass_kg(plant);
  model.inertia_kg_m2 = {0.0347563, 0.0458929, 0.0977};
  planner::place_rotors(model, 6, 0.215, 0.52359877559829887);
  model.thrust_n_s2 = plant.thrust_n_s2;
  model.moment_m = plant.moment_m;
  model.tau_up_s = plant.tau_up_s;
  model.tau_down_s = plant.tau_down_s;
  model.max_speed_rad_s = plant.max_speed_rad_s;
  return model;
}

}  // namespace

CampaignOutcome run_path_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  planner::FlightMapConfig config = planner::test::cube(24, 20, 12, 0.2, 0.15);
  const auto owned = std::make_unique<planner::test::OwnedMap>(config);
  // Now and then with tables that are too small for any way.
  const std::uint32_t nodes = !ops.empty() && ops[0].value[6] > 0.8 ? 16 : 2048;
  const auto path = std::make_unique<planner::test::OwnedPath>(owned->map, nodes, nodes, 64);
  planner::FlightMap& map = owned->map;
  trial.need(map.usable() == Status::ok, "the map is not usable");
  std::uint32_t unsafe = 0;
  bool fresh = map.refresh(UINT32_MAX);
  bool current = false;  // the map is as it was when the way was asked for
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    const rt::Vector3 middle{-0.6, 3.0, 0.8};
    const rt::Vector3 from = middle + rt::Vector3{2.4 * v[0], 2.0 * v[1], 1.2 * v[2]};
    const rt::Vector3 to = middle + rt::Vector3{2.4 * v[3], 2.0 * v[4], 1.2 * v[5]};
    if (op.kind % 4 < 2) current = false;
    if (op.kind % 4 == 0) {
      const planner::Voxel3 at = map.voxel_at(from);
      fresh =
          trial.answered(trial.real_time([&] { return map.set_blocked(at, v[6] > -0.7); })) != Status::ok &&
          fresh;
    } else if (op.kind % 4 == 1) {
      fresh = trial.real_time([&] { return map.refresh(whole_of(v[0], 20)); });
      trial.fold(fresh ? 1 : 0);
    } else {
      if (op.kind % 4 == 2) {
        const planner::PathState asked = trial.real_time([&] { return path->path.begin(map, from, to); });
        trial.count(asked == planner::PathState::running);
        current = fresh;
      }
      const std::uint64_t units = 1 + whole_of(v[6], 4000);
      const std::uint64_t before = path->path.work().units;
      const planner::PathState state = trial.real_time([&] { return path->path.step(map, units); });
      trial.need(path->path.work().units - before <= units + 20'000, "far more units were spent than given");
      trial.fold(static_cast<std::uint64_t>(state));
      // In a map that is not worked off the search meets voxels that are older than the walls: the check is
      // for that.
      trial.need(!fresh || path->path.work().unsafe == unsafe,
                 "the exact check refused a way in a map that is up to date");
      unsafe = path->path.work().unsafe;
      for (const rt::Vector3& point : path->path.waypoints()) {
        trial.need(rt::is_finite(point), "a waypoint is not finite");
        trial.fold(std::bit_cast<std::uint64_t>(point.x));
      }
      trial.see(path->path.length_m(), "the way's length is not finite");
      const bool shown = state == planner::PathState::found || state == planner::PathState::done;
      trial.need(!shown || !current || planner::test::is_still_free(map, path->path.waypoints()),
                 "a way is shown that is not free");
      trial.need(!shown || path->path.waypoints().size() >= 2, "a way was found that has no points");
    }
  }
  return trial.end();
}

CampaignOutcome run_drive_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  constexpr double kStep = 0.01;
  const planner::TwistLimits limits;
  const planner::TwistRamps ramps;
  planner::TwistLimiter limiter;
  planner::WaypointFollowerConfig config;
  config.repeat = true;
  planner::WaypointFollower follower(config);
  planner::SpeedTurn wish;
  rt::Nanoseconds now_ns = 0;
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    if (op.kind % 4 == 0) {
      const planner::Waypoint route[3] = {{5.0 * v[0], 5.0 * v[1]}, {5.0 * v[2], 5.0 * v[3]}, {v[4], v[5]}};
      trial.given(trial.real_time([&] { return follower.set_route(route); }));
      if (v[6] > 0.9) follower.encourage();
    } else if (op.kind % 4 == 1) {
      // The follower is promised finite poses, at any place and any heading.
      rt::PoseEstimate pose;
      for (std::size_t i = 0; i < 2; ++i) pose.p_world_body_m[i] = std::isfinite(v[i]) ? v[i] : 0.0;
      const double yaw = std::isfinite(v[2]) ? 3.0 * v[2] : 0.0;
      rt::store(rt::exp_rotation({0, 0, std::fabs(yaw) < 1e3 ? yaw : 0.0}), pose.q_world_body);
      now_ns += std::clamp<std::int64_t>(op.step_ns, 0, 100'000'000'000);
      wish = trial.real_time([&] { return follower.wish(pose, limits, ramps, now_ns); });
      trial.see(wish, "the follower's wish is not finite");
    } else {
      const planner::SpeedTurn asked{v[0], 2.0 * v[1]};
      const bool finite = std::isfinite(asked.speed_m_s) && std::isfinite(asked.turn_rad_s);
      if (finite) wish = asked;
      trial.count(finite);
    }
    const planner::SpeedTurn before = limiter.now();
    const double before_rate = limiter.speed().rate;
    trial.real_time([&] {
      limiter.step(wish, limits, ramps, kStep);
      return 0;
    });
    const planner::SpeedTurn now = limiter.now();
    trial.see(now, "speed or turn rate is not finite");
    constexpr double kRounding = 1.0 + 1e-6;
    trial.need(std::fabs(now.speed_m_s) <= limits.max_speed_m_s * kRounding, "the speed is beyond its limit");
    trial.need(std::fabs(now.turn_rad_s) <= limits.max_turn_rad_s * kRounding,
               "the turn rate is beyond its limit");
    trial.need(std::fabs(now.speed_m_s) + limits.lever_m * std::fabs(now.turn_rad_s) <=
                   limits.max_track_m_s * kRounding,
               "a belt is beyond its limit");
    trial.need(std::fabs(now.speed_m_s - before.speed_m_s) <= ramps.speed.acceleration * kStep * kRounding,
               "the acceleration is beyond its limit");
    trial.need(std::fabs(limiter.speed().rate - before_rate) <= ramps.speed.jerk * kStep * kRounding,
               "the jerk is beyond its limit");
  }
  return trial.end();
}

CampaignOutcome run_flight_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  planner::UavControlConfig config;
  config.model = plain_hexacopter();
  static const planner::UavControl kDesigned(config);  // some ms: once
  const auto control = std::make_unique<planner::UavControl>(kDesigned);
  rt::UavState state;
  state.p_world_m[2] = 2.0;
  state.verdict = rt::UavVerdict::good;
  trial.need(control->start(state) == Status::ok, "the controller does not start");
  CampaignClock clock;
  std::uint64_t refused = 0;
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    const rt::Vector3 place{5.0 * v[0], 5.0 * v[1], 2.0 + v[2]};
    if (op.kind % 8 == 0) trial.given(trial.real_time([&] { return control->set_goal(place, 3.0 * v[3]); }));
    if (op.kind % 8 == 1) {
      planner::FlatReference reference;
      reference.p_m = place;
      reference.v_m_s = {v[3], v[4], v[5]};
      reference.yaw_rad = v[6];
      trial.given(trial.real_time([&] { return control->track(reference); }));
    }
    if (op.kind % 64 == 2) control->hover();
    if (op.kind % 64 == 3) control->land();
    state.stamp_ns = clock.step(op);
    rt::store(place, state.p_world_m);
    rt::store(rt::Vector3{v[3], v[4], v[5]}, state.v_world_m_s);
    rt::store(rt::exp_rotation({0.3 * v[4], 0.3 * v[5], v[6]}), state.q_world_body);
    rt::store(rt::Vector3{v[6], v[5], v[4]}, state.w_body_rad_s);
    rt::store(rt::Vector3{0.1 * v[3], 0.1 * v[0], 0.1 * v[1]}, state.d_world_m_s2);
    state.verdict = op.kind % 16 == 5 ? rt::UavVerdict::lost : rt::UavVerdict::good;
    rt::RotorCommand command;
    const Status status = trial.answered(trial.real_time([&] { return control->update(state, command); }));
    refused += status == Status::ok ? 0 : 1;
    trial.see(command, "a rotor's command is not finite");
    trial.need(command.rotors == 6, "the command is for another number of rotors");
    for (std::uint32_t i = 0; i < 6; ++i)
      trial.need(command.speed_rad_s[i] >= 0.0 &&
                     command.speed_rad_s[i] <= config.model.max_speed_rad_s * (1 + 1e-9),
                 "a rotor's command is beyond its range");
    trial.see(control->reference(), "the reference is not finite");
  }
  trial.need(control->counters().states_refused == refused, "refused states are miscounted");
  return trial.end();
}

CampaignOutcome run_riccati_trial(std::span<const CampaignOp> ops) {
  CampaignTrial trial;
  using planner::DoubleDouble;
  for (const CampaignOp& op : ops) {
    const auto& v = op.value;
    planner::Dare<DoubleDouble, 2, 1> problem;
    const double wild = op.kind % 3 == 0 ? 1e6 : 1.0;
    problem.a(0, 0) = DoubleDouble(1.0 + 0.5 * v[0]);
    problem.a(0, 1) = DoubleDouble(wild * v[1]);
    problem.a(1, 1) = DoubleDouble(1.0 + 0.5 * v[2]);
    problem.b(0, 0) = DoubleDouble(op.kind % 3 == 1 ? 0.0 : v[3]);
    problem.b(1, 0) = DoubleDouble(v[4]);
    problem.q(0, 0) = problem.q(1, 1) = DoubleDouble(std::fabs(v[5]));
    problem.r(0, 0) = DoubleDouble(std::fabs(v[6]) / wild);
    planner::SmallMatrix<DoubleDouble, 1, 2> gain;
    planner::DareReport report;
    const Status status = trial.answered(trial.real_time([&] { return problem.solve_gain(gain, report); }));
    if (status != Status::ok) continue;
    trial.need(report.stable && report.radius < 1.0, "a gain was handed out that does not hold the system");
    trial.need(report.residual <= 1e-10, "a gain was handed out that does not solve the equation");
    for (std::size_t i = 0; i < 2; ++i) trial.see(static_cast<double>(gain(0, i)), "a gain is not finite");
  }
  return trial.end();
}

}  // namespace sortie::bench
