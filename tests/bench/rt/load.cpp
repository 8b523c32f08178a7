// SPDX-License-Identifier: BSD-3-Clause
// Twice the demand on one core, and a task that is stuck: what the supervisor does about it.
#include <algorithm>
#include <cmath>

#include "tests/bench/overload.hpp"
#include "tests/bench/rt/measure.hpp"

namespace sortie::bench {

namespace {

void add(Report& report, const char* what, const char* unit, std::uint64_t n, const Json& ours,
         const char* goal, bool met) {
  Figure figure;
  figure.group = "overload";
  figure.what = what;
  figure.unit = unit;
  figure.n = n;
  figure.ours = ours;
  if (goal != nullptr) set_goal(figure, goal, met);
  report.add(figure);
}

}  // namespace

void measure_load(const Settings& settings, Report& report) {
  say("overload and watchdog");
  if (!settings.realtime || settings.other_core < 0) {
    report.skip("overload", settings.realtime ? "this needs two cores" : "this needs SCHED_FIFO");
    return;
  }
  OverloadOptions options;
  options.rounds = settings.rounds;
  options.core = settings.core;
  const OverloadResult result = measure_overload(options);
  std::uint64_t lost = 0;
  std::uint64_t in_order = 0;
  Rounds step;
  Rounds recovery;
  for (const OverloadRound& round : result.rounds) {
    lost += round.a_lost;
    in_order += round.in_order ? 1 : 0;
    step.add(round.first_step_ms);
    recovery.add(round.recovery_ms);
  }
  // Both counts are of rare events: they may differ by chance.
  const double more = static_cast<double>(lost) - static_cast<double>(result.a_lost_calm);
  const double chance = 3 * std::sqrt(static_cast<double>(lost + result.a_lost_calm));
  add(report, "A: jobs lost at twice the demand", "", result.a_releases, spread(static_cast<double>(lost)),
      "as in calm times, within 3 sigma", more <= chance);
  add(report, "A: jobs lost in calm times beside it", "", result.a_releases,
      spread(static_cast<double>(result.a_lost_calm)), nullptr, false);
  const auto rounds = static_cast<std::uint64_t>(result.rounds.size());
  add(report, "rounds in which C went before B", "", rounds, spread(static_cast<double>(in_order)), "all",
      in_order == rounds);
  add(report, "first step of the ladder", "ms", rounds, spread(step), nullptr, false);
  add(report, "recovery", "ms", rounds, spread(recovery), "<= 100 ms", recovery.median() <= 100);
  Rounds periods;
  for (const double value : measure_watchdog(std::min(settings.rounds, 20), options)) periods.add(value);
  if (periods.empty()) return;
  add(report, "a stuck task is told after", "periods", periods.size(), spread(periods), "<= 2",
      periods.high() <= 2);
}

}  // namespace sortie::bench
