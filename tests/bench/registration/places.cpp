// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "tests/bench/registration/placed_locator.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;

void places(bool forgets, const RegistrationSettings& settings) {
  const int cases = settings.cases > 0 ? settings.cases : 3000;
  testing::Draws draws(settings.seed);
  Rounds ms;
  int n = 0;
  int verdicts[16]{};
  for (int hall_number = 0; n < cases; ++hall_number) {
    PlacedLocator locator(Hall(draws), draws, forgets);
    for (int i = 0; i < kScansOfHall && n < cases; ++i, ++n) {
      const PlacedScan scan = Hall(draws).scan(draws);
      const Trial trial = locator.offer(scan, scan.pose);
      const mapping::Located& located = trial.located;
      ms.add(trial.ms);
      ++verdicts[static_cast<std::size_t>(located.verdict)];
      const bool taken = located.verdict == mapping::LocateVerdict::accepted ||
                         located.verdict == mapping::LocateVerdict::new_place;
      if (settings.each && taken) {
        std::printf("%s: hall %d scan %d, matched %.2f known %.2f crossed %.3f inside %.3f weak %u %u\n",
                    to_string(located.verdict), hall_number, i, located.share, located.known, located.crossed,
                    located.inside, located.weak_moves, located.weak_turns);
      }
    }
  }
  const auto of = [&verdicts](mapping::LocateVerdict verdict) {
    return verdicts[static_cast<std::size_t>(verdict)];
  };
  using mapping::LocateVerdict;
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %.1f | %.1f |\n",
              forgets ? "long lost" : "tracked so far", n, of(LocateVerdict::accepted),
              of(LocateVerdict::new_place), of(LocateVerdict::little_share), of(LocateVerdict::crossed),
              of(LocateVerdict::ambiguous), of(LocateVerdict::unheld), ms.median(), ms.high());
  std::fflush(stdout);
}

}  // namespace

void registration_places(const RegistrationSettings& settings) {
  std::puts(
      "\n| robot | scans of other halls | accepted | new place | little share | crossed | ambiguous | unheld "
      "| "
      "ms median | max |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
  places(false, settings);
  places(true, settings);
}

}  // namespace sortie::bench
