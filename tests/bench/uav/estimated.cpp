// SPDX-License-Identifier: BSD-3-Clause
// Flights on the estimate, and on commands that come late.
#include "tests/bench/report/picture.hpp"
#include "tests/bench/uav/uav_parts.hpp"

namespace sortie::bench {

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

void measure_uav_orders(const UavSettings& settings, Report& report) {
  struct Order {
    Navigator navigator;
    const char* name;
  };
  Json rows = Json::array();
  Picture picture{"bench-uav-orders",
                  "orders",
                  "Error over run time, by estimator",
                  "run time of the estimator, \u00b5s per second of flight",
                  "RMS, mm",
                  true,
                  true,
                  false,
                  {}};
  Curve flown{"position flown", {}, {}, {}, "dots"};
  Curve estimated{"position estimated", {}, {}, {}, "dots"};
  for (const Order& order : {Order{Navigator::full, "15 states"},
                             {Navigator::no_acc_bias, "no accelerometer bias"},
                             {Navigator::complementary, "complementary"}}) {
    Rounds rms;
    Rounds peak;
    Rounds estimate;
    Rounds dark;
    double cost = 0.0;
    for (std::uint64_t seed = 1; seed <= settings.seeds; ++seed) {
      FlightSetup setup = usual_flight("neo11", Pilot::ours, 1.1, 5.0, false, seed);
      setup.estimated = true;
      setup.navigator = order.navigator;
      setup.time_estimate = seed == 1;
      const FlightResult result = fly(setup);
      rms.add(result.rms_m);
      peak.add(result.peak_m);
      estimate.add(result.estimate_rms_m);
      if (seed == 1) cost = result.estimate_cost_us_s;
      setup.time_estimate = false;
      setup.dark_from_s = 20.5;
      setup.dark_to_s = 21.0;
      dark.add(fly(setup).peak_m);
    }
    rows.push_back({order.name, cost, estimate.median(), rms.median(), peak.median(), dark.median()});
    for (Curve* curve : {&flown, &estimated}) {
      curve->x.push_back(cost);
      curve->labels.push_back(order.name);
    }
    flown.y.push_back(1e3 * rms.median());
    estimated.y.push_back(1e3 * estimate.median());
  }
  report.add_table("orders",
                   {"estimator", "run time us per s", "estimate's RMS m", "flown RMS m", "peak m",
                    "peak m, 0.5 s without fixes"},
                   rows);
  report.note(
      "orders",
      "The usual flight on estimates: ADIS16448 at 200 Hz, fixes at 20 Hz, 50 +-10 ms late, 2 % lost. "
      "The one without accelerometer bias is the same program, sure that there is none: it costs as "
      "much. Complementary: fixed gains, fixes compared with where the filter was at their stamp.");
  picture.curves = {flown, estimated};
  add_picture(report, picture);
}

}  // namespace sortie::bench
