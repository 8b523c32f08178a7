// SPDX-License-Identifier: BSD-3-Clause
// From points to pose: a camera's cloud from the air on a laser's cloud from the ground.
#include <catch2/catch.hpp>

#include "tests/mapping/air_ground_trials.hpp"

TEST_CASE("Clouds of air and ground: what is placed is right to 5 cm, 0.3 degrees and 0.5 % of scale",
          "[heavy]") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 9000;
  CAPTURE(kSeed);
  const tests::AirGroundTally out = tests::air_ground_trials(kSeed, 20).known;
  CAPTURE(out.scenes, out.tally.close, out.tally.near, out.tally.wrong, out.tally.refused);
  CHECK(out.scenes >= 10);
  CHECK(out.tally.close >= 3);
  CHECK(out.tally.near == 0);
  CHECK(out.tally.wrong == 0);
}

TEST_CASE("Clouds of corridors, bare floors and pairs of walls: no direction that was not seen is made up",
          "[heavy]") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 9500;
  CAPTURE(kSeed);
  const tests::AirGroundTally out = tests::deficient_trials(kSeed, 12);
  CAPTURE(out.tally.close, out.tally.near, out.tally.wrong, out.tally.refused);
  CHECK(out.scenes == 12);
  CHECK(out.tally.wrong == 0);
}
