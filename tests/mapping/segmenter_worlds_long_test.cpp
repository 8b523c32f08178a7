// SPDX-License-Identifier: BSD-3-Clause
// A thousand random worlds: longer than the unit tests have time for.
#include <catch2/catch.hpp>

#include "tests/mapping/random_worlds.hpp"

TEST_CASE("The Euclidean partition is that of brute force in a thousand random worlds") {
  const sortie::tests::WorldVerdict verdict = sortie::tests::euclidean_worlds(1000, 1000, 25);
  CHECK(verdict.ticks == 25000);
  CHECK(verdict.wrong == 0);
  CHECK(verdict.not_current == 0);
}
