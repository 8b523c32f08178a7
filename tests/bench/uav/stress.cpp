// SPDX-License-Identifier: BSD-3-Clause
// One stress at a time, steps, lost rotors, and vehicles that nobody tuned for.
#include <algorithm>
#include <cmath>

#include "tests/bench/uav/uav_parts.hpp"

namespace sortie::bench {
namespace {

constexpr double kDegreesOf = 180.0 / 3.14159265358979323846;
constexpr double kGustAt_s = 4.0;
constexpr double kBackAt_s = kGustAt_s + 2.0 + 5.0;

void add_stress(Report& report, Json& rows, const std::string& name, const FlightSetup& setup) {
  const FlightResult result = fly(setup);
  const double late = result.finite ? late_error_m(result, kBackAt_s) : 1e9;
  add_limit(report, "stress", name + ", 5 s later", "m", late, 0.05);
  rows.push_back({name, result.rms_m, result.peak_m, late, result.max_tilt_rad * kDegreesOf});
}

void measure_move(const std::string& vehicle, Report& report) {
  FlightSetup setup = flight_setup(vehicle);
  setup.seconds = 5.0;
  setup.judged = [](double time_s) {
    planner::FlatReference r;
    r.p_m = {time_s < 1.0 ? 0.0 : 1.0, 0, 5};
    return r;
  };
  setup.command = [](double time_s, planner::UavControl& control) {
    if (time_s >= 1.0 && time_s < 1.005) (void)control.set_goal({1, 0, 5}, 0);
  };
  const FlightResult result = fly(setup);
  double arrival_s = 0.0;
  double beyond_m = 0.0;
  for (const FlightSample& sample : result.record) {
    if (sample.time_s < 1.0) continue;
    if (sample.error_m > 0.02) arrival_s = sample.time_s - 1.0 + setup.control.period_s;
    beyond_m = std::max(beyond_m, sample.p_m.x - 1.0);
  }
  add_limit(report, "moves", vehicle + ": 1 m to within 2 cm", "s", arrival_s, 1.3);
  add_limit(report, "moves", vehicle + ": overshoot of 1 m", "%", 100.0 * beyond_m, 2.0);
}

void measure_absurd(std::uint64_t seeds, Report& report) {
  double tilt = 0.0;
  bool finite = true;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    FlightSetup setup = usual_hover("neo11", seed);
    hil::Random random(seed, 99);
    setup.command = [random](double time_s, planner::UavControl& control) mutable {
      const double kind = random.uniform();
      const double far = random.uniform(-500, 500);
      if (std::fmod(time_s, 0.5) < 0.01) (void)control.set_goal({far, -far, 5 + random.uniform(-3, 30)}, far);
      planner::FlatReference wild = control.reference();
      wild.p_m.x += random.uniform(-30, 30);
      wild.a_m_s2.y = kind < 0.3 ? std::nan("") : far;
      (void)control.track(wild);
    };
    const FlightResult result = fly(setup);
    tilt = std::max(tilt, result.max_tilt_rad * kDegreesOf);
    finite = finite && result.finite;
  }
  add_limit(report, "moves", "absurd goals: greatest tilt", "deg", finite ? tilt : 180.0, 40.0);
}

void measure_lost_rotor(const std::string& vehicle, Report& report) {
  double tilt = 0.0;
  double sink = 0.0;
  double off = 0.0;
  for (std::uint32_t rotor = 0; rotor < 6; ++rotor) {
    FlightSetup setup = usual_hover(vehicle, rotor + 1);
    setup.seconds = 25.0;
    setup.lose_rotor = rotor;
    setup.lose_rotor_at_s = 3.0;
    const FlightResult result = fly(setup);
    const hil::TouchDown& down = result.touch_down;
    tilt = std::max(tilt, result.max_tilt_rad * kDegreesOf);
    sink = std::max(sink, down.happened ? down.speed_m_s : 1e9);
    off = std::max(off, std::hypot(down.p_world_m.x, down.p_world_m.y));
  }
  add_limit(report, "lost rotor", vehicle + ": greatest tilt, any of six", "deg", tilt, 35.0);
  add_limit(report, "lost rotor", vehicle + ": speed at touch-down", "m/s", sink, 1.0);
  add_limit(report, "lost rotor", vehicle + ": place of touch-down", "m", off, 2.0);
}

void measure_fleet(std::uint64_t count, Report& report) {
  double bad = 0.0;
  double worst = 0.0;
  for (std::uint64_t seed = 1; seed <= count; ++seed) {
    FlightSetup setup = random_vehicle(seed);
    setup.noise = kUsualNoise;
    setup.seed = seed;
    setup.seconds = 12.0;
    hover_at(setup, 5.0);
    setup.gusts = {diagonal_gust(0.5 * 9.81 * setup.control.model.mass_kg, kGustAt_s)};
    const FlightResult result = fly(setup);
    const double late = late_error_m(result, kBackAt_s);
    if (!result.finite || late > 0.05 || result.counters.rotors_lost > 0) bad += 1.0;
    worst = std::max(worst, result.peak_m);
  }
  add_limit(report, "fleet", "drawn vehicles not back within 5 cm, of " + std::to_string(count), "", bad,
            0.0);
  report.note("fleet",
              "Gusts of half the weight for 2 s; greatest error of any " + std::to_string(worst) + " m.");
}

}  // namespace

void measure_uav_stress(const UavSettings& settings, Report& report) {
  Json rows = Json::array();
  const auto neo11 = [] {
    FlightSetup setup = usual_hover("neo11", 1);
    setup.gusts = {diagonal_gust(5.0, kGustAt_s)};
    return setup;
  };
  FlightSetup setup = neo11();
  setup.position_delay_s = 0.1;
  add_stress(report, rows, "position 100 ms late", setup);
  for (const double share : {0.7, 1.6}) {
    setup = neo11();
    set_mass(setup, share * setup.control.model.mass_kg);
    add_stress(report, rows, share < 1.0 ? "mass -30 %" : "mass +60 %", setup);
  }
  setup = neo11();
  setup.thrust_share = 0.8;
  add_stress(report, rows, "thrust -20 %", setup);
  setup = neo11();
  setup.gusts = {diagonal_gust(20.0, kGustAt_s)};
  add_stress(report, rows, "gust 20 N", setup);
  for (const char* vehicle : {"neo9", "firefly"}) {
    setup = usual_hover(vehicle, 1);
    const planner::UavModel& model = setup.control.model;
    setup.gusts = {diagonal_gust(0.5 * model.mass_kg * 9.81, kGustAt_s)};
    add_stress(report, rows, std::string(vehicle) + ", gust 0.5 m g", setup);
    setup = usual_hover(vehicle, 1);
    set_mass(setup, 6.0 * model.max_thrust_n() / 9.81 / 1.4);
    add_stress(report, rows, std::string(vehicle) + ", thrust/weight 1.4", setup);
  }
  report.add_table("stress", {"stress", "RMS m", "peak m", "5 s later m", "tilt deg"}, rows);
  for (const char* vehicle : {"neo11", "neo9", "firefly"}) measure_move(vehicle, report);
  measure_absurd(settings.seeds, report);
  for (const char* vehicle : {"neo11", "firefly", "neo9"}) measure_lost_rotor(vehicle, report);
  measure_fleet(settings.fleet, report);
}

}  // namespace sortie::bench
