// SPDX-License-Identifier: BSD-3-Clause
// A lidar alone that moves far from scan to scan: refused, or right.
#include <catch2/catch.hpp>

#include "tests/mapping/alone_trials.hpp"

TEST_CASE("A lidar alone that moves up to 1.5 m from scan to scan is placed rightly, or not at all",
          "[heavy]") {
  using namespace sortie::testing;
  int placed = 0;
  for (const AlonePlace place : kAlonePlaces) {
    for (const double speed_m : kAloneSpeeds_m) {
      AloneTally tally;
      try_alone(place, speed_m, 1004, tally);
      INFO(name_of(place) << ", " << speed_m << " m a scan, worst " << tally.worst_m << " m, "
                          << tally.worst_rad << " rad");
      // Known to fail in a bare corridor: docs/registration.md.
      if (place != AlonePlace::bare_corridor) CHECK(tally.wrong == 0);
      placed += tally.accepted;
    }
  }
  CHECK(placed > 0);
}

TEST_CASE("In a bare corridor a lidar alone does not seem to stand still", "[heavy]") {
  using namespace sortie::testing;
  // Corridors in which rows that cross the edge of wall and ceiling looked like surfaces.
  for (const std::uint64_t seed : {7001, 7005, 7006}) {
    AloneTally tally;
    try_alone(AlonePlace::bare_corridor, 0.9, seed, tally);
    CAPTURE(seed, tally.accepted, tally.worst_m);
    CHECK(tally.wrong == 0);
  }
}
