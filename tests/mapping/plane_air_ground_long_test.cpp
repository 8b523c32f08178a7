// SPDX-License-Identifier: BSD-3-Clause
// Some hundreds of buildings from points to pose, as rows of a table.
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/mapping/air_ground_trials.hpp"

namespace {
void print_air_ground_row(const char* name, const sortie::tests::AirGroundTally& t, std::uint32_t seed) {
  using sortie::tests::quantile;
  constexpr double kDeg = 57.29577951308232;
  std::printf("| %s | %u | %u | %u | %u | %u | %.1f, %.1f, %.1f | %.3f, %.3f, %.3f | %.3f, %.3f | %u |\n",
              name, t.scenes, t.tally.close, t.tally.near, t.tally.refused, t.tally.wrong,
              1e3 * quantile(t.position_m, 0.5), 1e3 * quantile(t.position_m, 0.95),
              1e3 * quantile(t.position_m, 1.0), kDeg * quantile(t.angle_rad, 0.5),
              kDeg * quantile(t.angle_rad, 0.95), kDeg * quantile(t.angle_rad, 1.0),
              100 * quantile(t.scale, 0.95), 100 * quantile(t.scale, 1.0), seed);
}
}  // namespace

TEST_CASE("Of hundreds of clouds from the air none is placed wrongly on those from the ground") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 60000;
  CAPTURE(kSeed);
  std::printf(
      "| scenes | n | placed | near | refused | wrong | mm median, p95, max | deg median, p95, max | scale "
      "%% p95, max | seed "
      "|\n"
      "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
  const char* const names[2][5] = {
      {"nothing known, < 45 % other planes", "45 to 55 %", "55 to 65 %", "> 65 %", "too few faces in common"},
      {"3 m and 6 deg known, < 45 %", "45 to 55 %", "55 to 65 %", "> 65 %", "too few faces in common"}};
  const tests::AirGroundRuns runs = tests::air_ground_trials(kSeed, 500);
  for (int known = 0; known < 2; ++known) {
    for (int k = 0; k < 5; ++k) {
      const tests::AirGroundTally& out = runs.of[known][k];
      print_air_ground_row(names[known][k], out, kSeed);
      CHECK(out.tally.wrong == 0);
    }
  }
}

TEST_CASE("Of 300 clouds that do not show all directions none is placed wrongly in those that they show") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 30000;
  CAPTURE(kSeed);
  const tests::AirGroundTally out = tests::deficient_trials(kSeed, 300);
  print_air_ground_row("corridor, floor, two walls", out, kSeed);
  CHECK(out.tally.wrong == 0);
  CHECK(tests::quantile(out.position_m, 1.0) < 0.02);
}
