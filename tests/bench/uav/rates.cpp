// SPDX-License-Identifier: BSD-3-Clause
// Error against run time: how often the controllers run, with the observer and without.
#include <algorithm>
#include <memory>

#include "tests/bench/report/picture.hpp"
#include "tests/bench/uav/lee.hpp"
#include "tests/bench/uav/pilot_cost.hpp"
#include "tests/bench/uav/uav_parts.hpp"

namespace sortie::bench {
namespace {

struct RatePilot {
  Pilot pilot;
  const char* name;
};
constexpr RatePilot kRatePilots[] = {{Pilot::lee, "Lee"},
                                     {Pilot::lee_integral, "Lee with integrator"},
                                     {Pilot::ours_unobserved, "ours, no observer"},
                                     {Pilot::ours, "ours"}};

}  // namespace

double pilot_cost_us_s(const FlightSetup& setup, const FlightResult& flown) {
  std::vector<planner::FlatReference> wanted;
  for (const FlightSample& sample : flown.record) wanted.push_back(setup.path(sample.time_s));
  const bool ours = setup.pilot == Pilot::ours || setup.pilot == Pilot::ours_unobserved;
  double least = 1e30;
  for (int round = 0; round < 5; ++round) {
    auto control = std::make_unique<planner::UavControl>(setup.control);
    LeeController lee(setup.control.model, lee_gains(setup.plant.name), setup.control.period_s);
    if (control->start(flown.record.front().state) != Status::ok) return 0.0;
    const double before = cpu_us();
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      rt::RotorCommand command;
      if (ours) {
        (void)control->track(wanted[k]);
        (void)control->update(flown.record[k].state, command);
      } else {
        lee.update(flown.record[k].state, wanted[k], command);
      }
    }
    least = std::min(least, cpu_us() - before);
  }
  return least / setup.seconds;
}

void measure_uav_sweep(const UavSettings& settings, Report& report) {
  Json rows = Json::array();
  Picture picture{"bench-uav-rates",
                  "rates",
                  "Error over run time, by control rate",
                  "run time of the controller, \u00b5s per second of flight",
                  "position RMS, mm",
                  true,
                  true,
                  false,
                  {}};
  for (const RatePilot& pilot : kRatePilots) {
    Curve curve;
    curve.name = pilot.name;
    if (pilot.pilot == Pilot::lee || pilot.pilot == Pilot::lee_integral) curve.style = "dashed";
    for (const double rate_hz : {25.0, 50.0, 100.0, 200.0, 500.0, 1000.0}) {
      Rounds rms;
      Rounds peak;
      double cost = 0.0;
      for (std::uint64_t seed = 1; seed <= settings.seeds; ++seed) {
        FlightSetup setup = usual_flight("neo11", pilot.pilot, 1.1, 5.0, true, seed);
        setup.control.period_s = 1.0 / rate_hz;
        setup.integral_share_hz = 0.25;
        const FlightResult result = fly(setup);
        rms.add(result.rms_m);
        peak.add(result.peak_m);
        if (seed == 1) cost = pilot_cost_us_s(setup, result);
      }
      rows.push_back({pilot.name, rate_hz, cost, rms.median(), peak.median()});
      curve.x.push_back(cost);
      curve.y.push_back(1e3 * rms.median());
      curve.labels.push_back(std::to_string(static_cast<int>(rate_hz)) + " Hz");
    }
    picture.curves.push_back(curve);
  }
  report.add_table("rates", {"pilot", "control rate Hz", "run time us per s", "RMS m", "peak m"}, rows);
  report.note(
      "rates",
      "The usual flight: 5 N gust, mass +10 %, noise. The noise is one draw a period whatever the rate, "
      "as from a sensor that is read faster. The observer belongs to the estimator: its run time is not in "
      "here, its bandwidth is held within a tenth of "
      "the rate.");
  add_picture(report, picture);
}

}  // namespace sortie::bench
