// SPDX-License-Identifier: BSD-3-Clause
// Some hundreds of buildings from points to pose, as rows of a table.
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/mapping/air_ground_trials.hpp"

TEST_CASE("Of hundreds of clouds from the air none is placed wrongly on those from the ground") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 60000;
  CAPTURE(kSeed);
  std::printf(
      "| scenes | n | placed | near | refused | wrong | mm median, p95, max | deg median, p95, max | scale "
      "%% p95, max | seed "
      "|\n"
      "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
  const tests::AirGroundRuns runs = tests::air_ground_trials(kSeed, 500);
  for (int known = 0; known < 2; ++known) {
    for (int k = 0; k < 5; ++k) {
      const tests::AirGroundTally& out = runs.of[known][k];
      tests::print_row(tests::kBinNames[known][k], out, kSeed);
      CHECK(out.tally.wrong == 0);
    }
  }
}

TEST_CASE("Of 300 clouds that do not show all directions none is placed wrongly in those that they show") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 30000;
  CAPTURE(kSeed);
  const tests::AirGroundTally out = tests::deficient_trials(kSeed, 300);
  tests::print_row("corridor, floor, two walls", out, kSeed);
  CHECK(out.tally.wrong == 0);
  CHECK(tests::quantile(out.position_m, 1.0) < 0.02);
}
