// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "tests/bench/registration/judged_match.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {
namespace {

constexpr int kScansOfHall = 20;
constexpr int kScansOfMap = 6;

/// A tracked robot's scan before had `usual_share`; 0: nothing is known of it.
void places(double usual_share, const RegistrationSettings& settings) {
  const int cases = settings.cases > 0 ? settings.cases : 3000;
  const mapping::RegistrationConfig config;
  testing::Draws draws(settings.seed);
  Rounds ms;
  int n = 0;
  int verdicts[16]{};
  for (int hall_number = 0; n < cases; ++hall_number) {
    const Hall hall(draws);
    const auto map = map_of(hall, config, kScansOfMap, draws);
    for (int i = 0; i < kScansOfHall && n < cases; ++i, ++n) {
      const Hall other(draws);
      const PlacedScan scan = other.scan(draws);
      const JudgedMatch judged = judged_match(*map, config, scan.points, scan.pose, usual_share);
      ms.add(judged.ms);
      ++verdicts[static_cast<std::size_t>(judged.verdict)];
      if (settings.each && judged.verdict == mapping::LocateVerdict::accepted) {
        std::printf("accepted: hall %d scan %d, matched %.2f known %.2f value %.3f crossed %.3f weak %u %u\n",
                    hall_number, i, judged.match.score.matched, judged.match.score.known,
                    judged.match.score.value, judged.crossed, judged.match.weak.moves,
                    judged.match.weak.turns);
      }
    }
  }
  const auto of = [&verdicts](mapping::LocateVerdict verdict) {
    return verdicts[static_cast<std::size_t>(verdict)];
  };
  using mapping::LocateVerdict;
  std::printf("| %.1f | %d | %d | %d | %d | %d | %d | %.1f | %.1f |\n", usual_share, n,
              of(LocateVerdict::accepted), of(LocateVerdict::little_share), of(LocateVerdict::crossed),
              of(LocateVerdict::ambiguous), of(LocateVerdict::unheld), ms.median(), ms.high());
  std::fflush(stdout);
}

}  // namespace

void registration_places(const RegistrationSettings& settings) {
  std::puts(
      "\n| usual share | scans of other halls | accepted | little share | crossed | ambiguous | unheld | ms "
      "median | max |\n|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
  places(0.9, settings);
  places(0.0, settings);
}

}  // namespace sortie::bench
