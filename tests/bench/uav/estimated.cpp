// SPDX-License-Identifier: BSD-3-Clause
// Flights on the estimate, control rates, plant steps, and instructions.
#include <algorithm>
#include <cmath>

#include "firmware_like/bench/instruction_count.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "tests/bench/uav/lee.hpp"
#include "tests/bench/uav/uav_parts.hpp"

namespace sortie::bench {
namespace {

constexpr int kCountedSteps = 3000;

}  // namespace

void measure_uav_estimated(const UavSettings& settings, Report& report) {
  Rounds rms;
  Rounds dark;
  Rounds estimate;
  for (std::uint64_t seed = 1; seed <= settings.seeds; ++seed) {
    FlightSetup setup = usual_flight("neo11", Pilot::ours, 1.1, 5.0, false, seed);
    setup.estimated = true;
    const FlightResult result = fly(setup);
    rms.add(result.rms_m);
    estimate.add(result.estimate_rms_m);
    setup.dark_from_s = 20.5;
    setup.dark_to_s = 21.0;
    dark.add(fly(setup).peak_m);
  }
  add_limit(report, "estimated", "position RMS, fixes 20 Hz, 50 +-10 ms late, 2 % lost", "m", rms.high(),
            0.04);
  add_limit(report, "estimated", "greatest error, no fixes for 0.5 s in the gust", "m", dark.high(), 0.10);
  add_limit(report, "estimated", "RMS of the estimate itself", "m", estimate.high(), 0.04);
  Rounds cost;
  Json rows = Json::array();
  for (const double delay_s : {0.0, 0.01, 0.02, 0.03}) {
    Rounds all;
    for (std::uint64_t seed = 1; seed <= settings.seeds; ++seed) {
      FlightSetup setup = usual_flight("neo11", Pilot::ours, 1.1, 5.0, true, seed);
      setup.command_delay_s = delay_s;
      all.add(fly(setup).rms_m);
    }
    rows.push_back({1e3 * delay_s, all.median(), all.high()});
    if (delay_s == 0.0) cost = all;
    if (delay_s == 0.02)
      add_limit(report, "estimated", "cost of 20 ms of command delay", "%",
                100.0 * (all.median() / cost.median() - 1.0), 20.0);
  }
  report.add_table("estimated", {"command delay ms", "RMS m", "worst RMS m"}, rows);
}

void measure_uav_steps(const UavSettings&, Report& report) {
  // The plant alone, in a fast flight with the same commands at each step size.
  const auto final_place = [](double step_s, hil::MultirotorMode mode) {
    FlightSetup setup = flight_setup("neo11");
    const LegPath path = rectangle(4.0, 8.0);
    setup.control.max_tilt_rad = 0.8;
    setup.path = [path](double time_s) { return path.at(4.0 + time_s); };
    setup.seconds = 4.0;
    setup.plant_step_s = 1e-4;
    const FlightResult truth = fly(setup);
    (void)truth;
    setup.plant_step_s = step_s;
    setup.mode = mode;
    return fly(setup).record.back().p_m;
  };
  Json rows = Json::array();
  const hil::Vec3 exact = final_place(1e-4, hil::MultirotorMode::exact);
  for (const double step_s : {1e-3, 2.5e-3, 5e-3, 1e-2}) {
    const double ours = hil::norm(final_place(step_s, hil::MultirotorMode::exact) - exact);
    const double theirs = hil::norm(final_place(step_s, hil::MultirotorMode::parity) - exact);
    rows.push_back({1e3 * step_s, 1e3 * ours, 1e3 * theirs});
    if (step_s == 1e-2)
      add_limit(report, "plant", "10 ms beside 0.1 ms after 4 s in closed loop", "mm", 1e3 * ours, 0.05);
  }
  report.add_table("plant", {"step ms", "Runge-Kutta, exact lag: mm", "as RotorS: mm"}, rows);
}

void measure_uav_sweep(const UavSettings& settings, Report& report) {
  Json rows = Json::array();
  for (const double rate_hz : {25.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
    Json line = {rate_hz};
    for (const Pilot pilot : {Pilot::lee, Pilot::ours_unobserved, Pilot::ours}) {
      Rounds rms;
      for (std::uint64_t seed = 1; seed <= settings.seeds; ++seed) {
        FlightSetup setup = usual_flight("neo11", pilot, 1.1, 5.0, true, seed);
        setup.control.period_s = 1.0 / rate_hz;
        rms.add(fly(setup).rms_m);
      }
      line.push_back(rms.median());
    }
    rows.push_back(line);
  }
  report.add_table("rates", {"control rate Hz", "Lee RMS m", "unobserved RMS m", "ours RMS m"}, rows);
}

int run_counted_pilots() {
  // Both get the states of one flight of ours, with noise and the gust.
  const FlightSetup setup = usual_flight("neo11", Pilot::ours, 1.1, 5.0, true, 1);
  const FlightResult flown = fly(setup);
  if (flown.record.size() < kCountedSteps) return 1;
  planner::UavControl ours(setup.control);
  LeeController lee(setup.control.model, lee_gains("neo11"), 0.01);
  if (ours.start(flown.record[0].state) != Status::ok) return 1;
  std::vector<planner::FlatReference> wanted;
  for (const FlightSample& sample : flown.record) wanted.push_back(setup.path(sample.time_s));
  firmware::start_counting();
  for (int pilot = 0; pilot < 2; ++pilot) {
    firmware::mark_count();
    for (std::size_t k = 0; k < kCountedSteps; ++k) {
      rt::RotorCommand command;
      if (pilot == 0) {
        (void)ours.track(wanted[k]);
        (void)ours.update(flown.record[k].state, command);
      } else {
        lee.update(flown.record[k].state, wanted[k], command);
      }
    }
    firmware::mark_count();
  }
  return 0;
}

void measure_uav_count(const UavSettings& settings, Report& report) {
  const Marks counted = count_instructions({settings.program, "--counted-pilots"});
  if (!counted.why_none.empty() || counted.instructions.size() != 4) {
    report.skip("instructions of a step", counted.why_none.empty() ? "marks are missing" : counted.why_none);
    return;
  }
  const auto per_step = [&](std::size_t at) {
    return static_cast<double>(counted.instructions[at + 1] - counted.instructions[at]) / kCountedSteps;
  };
  const double ours = per_step(0);
  const double theirs = per_step(2);
  Figure figure{"instructions",
                "of a control step",
                "",
                kCountedSteps,
                spread(ours),
                "Lee",
                spread(theirs),
                spread(ours / theirs),
                {},
                {}};
  set_goal(figure, "ratio <= 2", ours <= 2.0 * theirs);
  report.add(figure);
}

}  // namespace sortie::bench
