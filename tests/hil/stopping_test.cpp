// SPDX-License-Identifier: BSD-3-Clause
// A few of the runs of stopping_long_test.cpp: time and way to a stop are within what docs/safety.md
// promises, and random rows of deeds keep its promise.
#include <catch2/catch.hpp>

#include "tests/hil/stopping.hpp"

using namespace sortie::hil::test;

TEMPLATE_TEST_CASE("stopping: every cause stops the tracks in the promised time and way", "", CanopenKind,
                   OdriveKind) {
  for (const bool slope : {false, true}) {
    for (std::uint8_t c = 0; c < std::size(kStopCauses); ++c) {
      const auto cause = static_cast<StopCause>(c);
      const StopFigures figures = stop_many<TestType>(1, 12, cause, slope);
      const StopPromise promise = promised<TestType>(cause, slope);
      INFO(kStopCauses[c] << (slope ? ", down a slope" : ", flat") << ", seeds 1 to 12");
      CHECK(figures.refused == 0);
      CHECK(figures.ms.back() <= promise.ms);
      CHECK(figures.worst_m <= promise.m);
      CHECK(figures.ms.back() > 0);  // they were moving
    }
  }
}

TEMPLATE_TEST_CASE("stopping: random rows of faults move no wheel against the promise", "", CanopenKind,
                   OdriveKind) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) CHECK(random_row<TestType>(seed, 20) == "");
}
