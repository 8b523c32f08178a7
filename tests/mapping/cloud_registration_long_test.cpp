// SPDX-License-Identifier: BSD-3-Clause
// Some hundreds of pairs of clouds, true ones and false ones, as rows of a table. SORTIE_CLOUD_TRIALS: how
// many of each kind.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "tests/mapping/cloud_trials.hpp"

namespace {
std::uint32_t trials_of_clouds() {
  const char* const given = std::getenv("SORTIE_CLOUD_TRIALS");
  return given == nullptr ? 60u : static_cast<std::uint32_t>(std::atoi(given));
}

}  // namespace

TEST_CASE("Of many pairs of clouds none is placed wrongly by cells and lines of sight") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 60000;
  CAPTURE(kSeed);
  for (int known = 0; known < 2; ++known) {
    const tests::CloudRuns runs = tests::cloud_trials(0, known == 1, kSeed, trials_of_clouds());
    for (int k = 0; k < 5; ++k) tests::print_row(tests::kBinNames[known][k], runs.of[k], kSeed);
    std::printf("units of work: median %.1f M, p95 %.1f M, most %.1f M\n",
                1e-6 * tests::quantile(runs.units, 0.5), 1e-6 * tests::quantile(runs.units, 0.95),
                1e-6 * tests::quantile(runs.units, 1.0));
    CHECK(runs.wrong() == 0);
  }
}

TEST_CASE("Of many false pairs of clouds none is placed wrongly") {
  using namespace sortie;
  constexpr std::uint32_t kSeed = 62000;
  CAPTURE(kSeed);
  const char* const names[4] = {"", "looks nearly the same from both ends", "mirror image",
                                "another building"};
  for (int kind = 1; kind <= 3; ++kind) {
    for (const bool known : {false, true}) {
      const tests::CloudRuns runs = tests::cloud_trials(kind, known, kSeed, trials_of_clouds());
      std::printf("%s\n", known ? "3 m and 6 deg known:" : "nothing known:");
      for (const tests::AirGroundTally& tally : runs.of) {
        if (tally.scenes > 0) tests::print_row(names[kind], tally, kSeed);
      }
      CHECK(runs.wrong() == 0);
    }
  }
}
