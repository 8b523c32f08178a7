// SPDX-License-Identifier: BSD-3-Clause
// Belt mode: how well the vehicle turns, and about which centres, by load and friction; nothing of it is put
// in.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/bench/plant/plant_parts.hpp"

namespace sortie::bench {

namespace {

constexpr double kStep_s = 2e-3;
constexpr double kSpan_m = 2 * DrivePlan::kHalfSpan_m;
constexpr double kSettle_s = 4;
constexpr double kWatch_s = 2;
constexpr double kFrictions[] = {0.5, 0.7, 0.9, 1.2};
constexpr const char* kGroup = "belt";

// Where the load is.
struct Load {
  const char* name;
  double mass_scale;
  hil::Vec3 shift_m;  // of the body's centre of mass
};
constexpr Load kLoads[] = {{"as built", 1, {0, 0, 0}},
                           {"mass x 2", 2, {0, 0, 0}},
                           {"body 0.12 m ahead", 1, {0.12, 0, 0}},
                           {"body 0.12 m back", 1, {-0.12, 0, 0}},
                           {"body 0.06 m left", 1, {0, 0.06, 0}}};

struct Turn {
  const char* name;
  BeltSpeeds belts;
};
constexpr Turn kTurns[] = {{"on the spot", {-0.2, 0.2}}, {"circle", {0.1, 0.3}}};

// A settled turn.
struct Turning {
  double efficiency{};  // achieved over ideal rate
  double icr_x_m{};
  double icr_left_m{};
  double icr_right_m{};
  double change{};  // of the rate over the last two seconds, relative
};

Turning turn(const Load& load, double friction, const Turn& how) {
  hil::PlantScene scene;
  if (scene.add_half_space({0, 0, 1}, {0, 0, 0}) != Status::ok) throw std::runtime_error("no ground");
  hil::PlantConfig config;
  config.vehicle.mode = hil::ContactMode::belt;
  config.vehicle.friction = friction;
  config.vehicle.mass_scale = load.mass_scale;
  config.vehicle.body_centre_m = config.vehicle.body_centre_m + load.shift_m;
  const auto plant = std::make_unique<hil::TrackedPlant>(config, scene);
  hil::PlantCommand command;
  const double rise_s =
      std::max(std::fabs(how.belts.left_m_s), how.belts.right_m_s) / (0.25 * friction * 9.81);
  const auto run = [&](double from_s, double to_s) {
    for (double t = from_s; t < to_s - 0.5 * kStep_s; t += kStep_s) {
      const double share = std::min(1.0, (t + 0.5 * kStep_s) / rise_s);
      command.left_m_s = share * how.belts.left_m_s;
      command.right_m_s = share * how.belts.right_m_s;
      if (plant->step(command, kStep_s) != Status::ok) throw std::runtime_error("a step was refused");
    }
    return plant->state().velocity.angular.z;
  };
  const double before = run(0, kSettle_s);
  const double rate = run(kSettle_s, kSettle_s + kWatch_s);
  const hil::Vec3 v = plant->state().velocity.linear;
  Turning result;
  result.efficiency = rate * kSpan_m / (how.belts.right_m_s - how.belts.left_m_s);
  result.icr_x_m = -v.y / rate;
  result.icr_left_m = (v.x - how.belts.left_m_s) / rate;
  result.icr_right_m = (v.x - how.belts.right_m_s) / rate;
  result.change = std::fabs(rate - before) / std::fabs(rate);
  return result;
}

}  // namespace

void measure_plant_belt(const PlantSettings&, Report& report) {
  tell("belt mode: turning by load and friction");
  Json rows = Json::array();
  double restless = 0;
  std::uint64_t n = 0;
  for (const Turn& how : kTurns) {
    for (const Load& load : kLoads) {
      for (const double friction : kFrictions) {
        const Turning t = turn(load, friction, how);
        restless = std::max(restless, t.change);
        ++n;
        rows.push_back({how.name, load.name, friction, t.efficiency, 1e3 * t.icr_x_m, 1e3 * t.icr_left_m,
                        1e3 * t.icr_right_m});
      }
    }
  }
  Figure settled{kGroup,
                 "change of the turn rate from 4 s to 6 s, worst, relative",
                 "",
                 n,
                 spread(restless),
                 {},
                 {},
                 {},
                 {},
                 {}};
  set_goal(settled, "<= 1e-3: all settle", restless <= 1e-3);
  report.add(settled);
  report.add_table(
      kGroup, {"turn", "load", "friction", "steering efficiency", "ICR x mm", "ICR left mm", "ICR right mm"},
      rows);
  report.note(
      kGroup,
      "Belts at -0.2 and 0.2 m/s (on the spot) or 0.1 and 0.3 m/s (circle) on a plane. Steering "
      "efficiency is the turn rate over (right - left) / B, B = 0.397 m between the middles of the "
      "tracks. ICR x is the turning centre ahead of the vehicle's origin; ICR left and right are where "
      "each belt's speed fits the vehicle's motion, +-198.5 mm for tracks that do not slip. "
      "On level ground friction and weight cancel: where the load sits decides.");
}

}  // namespace sortie::bench
