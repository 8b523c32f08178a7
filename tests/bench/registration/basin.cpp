// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "tests/bench/registration/placed_locator.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;

/// Beyond it a wrong pose is not the map's own error of some millimetres.
constexpr double kRight_m = 0.02;
constexpr double kRight_deg = 0.2;

void basin(Report& report, Json& rows, const StartError& start_error, const RegistrationSettings& settings) {
  const int cases = settings.cases_or(3000);
  testing::Draws draws(settings.seed);
  Rounds ms;
  int right = 0;
  int near = 0;
  int far = 0;
  int n = 0;
  while (n < cases) {
    const Hall hall(draws);
    PlacedLocator locator(hall, draws, false);
    for (int i = 0; i < kScansOfHall && n < cases; ++i, ++n) {
      const PlacedScan scan = hall.scan(draws);
      const Trial trial = locator.offer(scan, start_beside(scan.pose, start_error, draws));
      const PoseError error = pose_error(trial.located.T_map_sensor, scan.pose);
      ms.add(trial.ms);
      if (trial.located.verdict != mapping::LocateVerdict::accepted) continue;
      if (error.within(kRight_m, kRight_deg))
        ++right;
      else
        ++(error.within(0.1, 1.0) ? near : far);
    }
  }
  const std::string what = decimals(start_error.move_m, 1) + " m, " +
                           decimals(start_error.turn_rad * 180 / M_PI, 0) + " deg, about " +
                           (start_error.upright ? "the upright" : "any axis");
  rows.push_back({what, n, right, near, far, n - right - near - far, decimals(ms.median(), 1),
                  decimals(ms.quantile(0.99), 1), decimals(ms.high(), 1)});
  Figure figure;
  figure.group = "basin";
  figure.what = "placed within 2 cm and 0.2 deg, start off by " + what;
  figure.unit = "%";
  figure.n = static_cast<std::uint64_t>(n);
  figure.ours = spread(100.0 * right / n);
  set_goal(figure, "99 at least, and none of the rest accepted farther off than 10 cm or 1 deg",
           right >= 0.99 * n && far == 0);
  report.add(figure);
}

}  // namespace

void measure_registration_basin(const RegistrationSettings& settings, Report& report) {
  Json rows = Json::array();
  for (const bool upright : {true, false}) {
    basin(report, rows, {0.5, 15 * M_PI / 180, upright}, settings);
    basin(report, rows, {1.0, 60 * M_PI / 180, upright}, settings);
  }
  report.add_table("basin",
                   {"start off by", "n", "accepted within 2 cm, 0.2 deg", "within 10 cm, 1 deg",
                    "farther off", "refused", "ms median", "p99", "max"},
                   rows);
  report.note("basin",
              "The locator as a whole, after six scans with good odometry; then each trial has odometry that "
              "is off by so much and claims nothing (10 m, 10 rad).");
}

}  // namespace sortie::bench
