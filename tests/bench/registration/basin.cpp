// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>

#include "tests/bench/registration/placed_locator.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;

/// Beyond it a wrong pose is not the map's own error of some millimetres.
constexpr double kRight_m = 0.02;
constexpr double kRight_deg = 0.2;

void print_each(const char* what, int hall, const PoseError& error, const mapping::Located& located) {
  std::printf("%s: hall %d, %.3f m %.2f deg, matched %.2f known %.2f crossed %.3f inside %.3f, %s\n", what,
              hall, error.move_m, error.turn_deg, located.share, located.known, located.crossed,
              located.inside, to_string(located.verdict));
}

void basin(const StartError& start_error, const RegistrationSettings& settings) {
  const int cases = settings.cases > 0 ? settings.cases : 3000;
  testing::Draws draws(settings.seed);
  Rounds ms;
  int right = 0;
  int near = 0;
  int far = 0;
  int refused = 0;
  int n = 0;
  for (int hall_number = 0; n < cases; ++hall_number) {
    const Hall hall(draws);
    PlacedLocator locator(hall, draws, false);
    for (int i = 0; i < kScansOfHall && n < cases; ++i, ++n) {
      const PlacedScan scan = hall.scan(draws);
      const Trial trial = locator.offer(scan, start_beside(scan.pose, start_error, draws));
      const PoseError error = pose_error(trial.located.T_map_sensor, scan.pose);
      ms.add(trial.ms);
      const bool accepted = trial.located.verdict == mapping::LocateVerdict::accepted;
      const bool is_right = accepted && error.within(kRight_m, kRight_deg);
      right += is_right ? 1 : 0;
      refused += accepted ? 0 : 1;
      near += accepted && !is_right && error.within(0.1, 1.0) ? 1 : 0;
      far += accepted && !is_right && !error.within(0.1, 1.0) ? 1 : 0;
      if (settings.each && !is_right)
        print_each(accepted ? "wrong" : "refused", hall_number, error, trial.located);
    }
  }
  std::printf("| %.1f m, %.0f deg, about %s | %d | %d (%.2f %%) | %d | %d | %d | %.1f | %.1f | %.1f |\n",
              start_error.move_m, start_error.turn_rad * 180 / M_PI,
              start_error.upright ? "the upright" : "any axis", n, right, 100.0 * right / n, near, far,
              refused, ms.median(), ms.quantile(0.99), ms.high());
  std::fflush(stdout);
}

}  // namespace

void registration_basin(const RegistrationSettings& settings) {
  std::puts(
      "\n| start off by | n | accepted within 2 cm, 0.2 deg | within 10 cm, 1 deg | farther off | refused | "
      "ms "
      "median | p99 | max |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|");
  for (const bool upright : {true, false}) {
    basin({0.5, 15 * M_PI / 180, upright}, settings);
    basin({1.0, 60 * M_PI / 180, upright}, settings);
  }
}

}  // namespace sortie::bench
