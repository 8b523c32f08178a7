// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/registration/placed_locator.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;

void places(Report& report, Json& rows, bool forgets, const RegistrationSettings& settings) {
  using mapping::LocateVerdict;
  const int cases = settings.cases_or(3000);
  testing::Draws draws(settings.seed);
  Rounds ms;
  int n = 0;
  int verdicts[16]{};
  while (n < cases) {
    PlacedLocator locator(Hall(draws), draws, forgets);
    for (int i = 0; i < kScansOfHall && n < cases; ++i, ++n) {
      const PlacedScan scan = Hall(draws).scan(draws);
      const Trial trial = locator.offer(scan, scan.pose);
      ms.add(trial.ms);
      ++verdicts[static_cast<std::size_t>(trial.located.verdict)];
    }
  }
  const auto of = [&verdicts](LocateVerdict verdict) { return verdicts[static_cast<std::size_t>(verdict)]; };
  const std::string who = forgets ? "long lost" : "tracked so far";
  rows.push_back({who, n, of(LocateVerdict::accepted), of(LocateVerdict::new_place),
                  of(LocateVerdict::little_share), of(LocateVerdict::crossed), of(LocateVerdict::ambiguous),
                  of(LocateVerdict::unheld), decimals(ms.median(), 1), decimals(ms.high(), 1)});
  Figure figure;
  figure.group = "places";
  figure.what = "scans of other halls that are accepted, robot " + who;
  figure.unit = "scans";
  figure.n = static_cast<std::uint64_t>(n);
  const int taken = of(LocateVerdict::accepted) + of(LocateVerdict::new_place);
  figure.ours = spread(taken);
  set_goal(figure, "none", taken == 0);
  report.add(figure);
}

}  // namespace

void measure_registration_places(const RegistrationSettings& settings, Report& report) {
  Json rows = Json::array();
  places(report, rows, false, settings);
  places(report, rows, true, settings);
  report.add_table("places",
                   {"robot", "n", "accepted", "new place", "little share", "crossed", "ambiguous", "unheld",
                    "ms median", "max"},
                   rows);
  report.note(
      "places",
      "Offered with odometry that claims nothing. Long lost: 60 scans were refused before, so that no "
      "share is usual any more.");
}

}  // namespace sortie::bench
