// SPDX-License-Identifier: BSD-3-Clause
// The same as in the short run over more kinds of missions, drifts and seeds.
#include <catch2/catch.hpp>

#include "tests/estimators/standing_compare.hpp"

using namespace sortie::estimators::test;

TEST_CASE("With short rests, long rests and long drives no mission ends worse for what rest taught") {
  for (const double instability : {0.0, 0.3, 1.0, 3.0, 10.0}) {
    compare("short rests", {0, instability, 1.5, 4, 20, 60}, 40);
    compare("long rests", {0, instability, 5, 20, 20, 60}, 40);
    compare("long drives", {0, instability, 1.5, 20, 60, 150}, 40);
  }
}
