// SPDX-License-Identifier: BSD-3-Clause
// The trials of the tracked plant in numbers: a thousand drops, a million steps under extremes.
#include "plant_trials.hpp"

using namespace sortie::hil;

TEST_CASE("plant: a thousand drops never gain energy", "[plant][long]") {
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    CAPTURE(seed);
    CHECK(gain_of_drop(seed) <= 1e-9);
  }
}

TEST_CASE("plant: a million random steps stay finite", "[plant][long]") {
  constexpr std::uint64_t kSeed = 77;
  CAPTURE(kSeed);
  const Shaken shaken = shake(kSeed, 1'000'000);
  CHECK(shaken.first_not_finite == -1);
  CHECK(shaken.wrong == 0);
  CHECK(shaken.rejected <= 10);
}
