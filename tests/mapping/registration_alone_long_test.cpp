// SPDX-License-Identifier: BSD-3-Clause
// A lidar alone through 480 drawn halls and corridors.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/mapping/alone_trials.hpp"

TEST_CASE(
    "Of thousands of scans of a lidar alone none is accepted that is off in a hall, and few in a corridor") {
  using namespace sortie::testing;
  const char* const wanted = std::getenv("SORTIE_ALONE_SEED");
  const std::uint64_t seed = wanted != nullptr ? std::strtoull(wanted, nullptr, 10) : 7'000;
  constexpr int kDrives = 30;
  std::puts("| place | m a scan | scans | accepted | of them off | worst, m | worst, rad |");
  for (const AlonePlace place : kAlonePlaces) {
    for (const double speed_m : kAloneSpeeds_m) {
      AloneTally tally;
      for (int i = 0; i < kDrives; ++i)
        try_alone(place, speed_m, seed + static_cast<std::uint64_t>(i), tally);
      std::printf("| %s | %.1f | %d | %d | %d | %.3f | %.4f |\n", name_of(place), speed_m, tally.scans,
                  tally.accepted, tally.wrong, tally.worst_m, tally.worst_rad);
      CAPTURE(name_of(place), speed_m, seed);
      // Known to fail in corridors, where standing still fits as well as any motion: docs/registration.md.
      const bool in_corridor = place == AlonePlace::corridor || place == AlonePlace::bare_corridor;
      CHECK(tally.wrong <= (in_corridor ? 0.05 * tally.scans : 0.0));
    }
  }
}
