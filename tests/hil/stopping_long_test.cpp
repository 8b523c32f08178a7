// SPDX-License-Identifier: BSD-3-Clause
// The promise of docs/safety.md, measured: 1,000 runs of each cause, 3,000 random rows of faults a protocol,
// and every order of eight deeds. Prints the tables of docs/results/stopping.md.
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/hil/stopping.hpp"

using namespace sortie::hil::test;

TEMPLATE_TEST_CASE("stopping: a thousand runs of each cause", "", CanopenKind, OdriveKind) {
  constexpr int kRuns = 1000;
  std::printf("\n**%s**\n\n", TestType::kName);
  std::printf(
      "| cause | ground | median [ms] | 99 %% [ms] | worst [ms] | bound [ms] | worst way [mm] | bound [mm] |"
      " with what it rolls, 2 s [mm] |\n|---|---|---|---|---|---|---|---|---|\n");
  for (std::uint8_t c = 0; c < std::size(kStopCauses); ++c) {
    for (const bool slope : {false, true}) {
      const auto cause = static_cast<StopCause>(c);
      const StopFigures figures = stop_many<TestType>(1, kRuns, cause, slope);
      const StopPromise promise = promised<TestType>(cause, slope);
      INFO(kStopCauses[c] << (slope ? ", down a slope" : ", flat") << ", seeds 1 to " << kRuns);
      REQUIRE(figures.ms.size() == kRuns);
      std::printf("| %s | %s | %.0f | %.0f | %.0f | %d | %.0f | %.0f | %.0f |\n", kStopCauses[c],
                  slope ? "20 deg down" : "flat", figures.ms[kRuns / 2], figures.ms[kRuns * 99 / 100],
                  figures.ms.back(), promise.ms, 1e3 * figures.worst_m, 1e3 * promise.m,
                  1e3 * figures.rolled_m);
      CHECK(figures.ms.back() <= promise.ms);
      CHECK(figures.worst_m <= promise.m);
    }
  }
}

TEMPLATE_TEST_CASE("stopping: three thousand random rows of faults", "", CanopenKind, OdriveKind) {
  int offences = 0;
  for (std::uint64_t seed = 1; seed <= 3000; ++seed) {
    const std::string found = random_row<TestType>(seed, 25);
    if (found.empty()) continue;
    ++offences;
    UNSCOPED_INFO(found);
  }
  std::printf("%s: %d of 3,000 random rows of 25 deeds are against the promise\n", TestType::kName, offences);
  CHECK(offences == 0);
}

TEMPLATE_TEST_CASE("drives model: every order of eight deeds", "", CanopenKind, OdriveKind) {
  for (const int rearm_ms : {0, 300}) {
    DrivesModel<TestType> model =
        asked_model<TestType>(false, rearm_ms * sortie::rt::kNanosecondsPerMillisecond);
    model.pass(600);
    REQUIRE(model.world.runtime().running());
    const SearchResult result = DrivesSearch<TestType>(8, 120, true)(model);
    std::string way;
    for (const int deed : result.way) way += " " + std::to_string(deed);
    INFO(result.found << ", deeds" << way);
    CHECK(result.found.empty());
    std::printf(
        "%s, re-arming after %d ms: %llu states gone on from, %llu more like one before, %llu running\n",
        TestType::kName, rearm_ms, static_cast<unsigned long long>(result.states),
        static_cast<unsigned long long>(result.alike), static_cast<unsigned long long>(result.running));
  }
}
