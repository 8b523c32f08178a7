// SPDX-License-Identifier: BSD-3-Clause
// The incremental segmenter against brute force, after every tick.
#include <catch2/catch.hpp>

#include "tests/mapping/random_worlds.hpp"

TEST_CASE("The Euclidean partition is that of brute force at every tick of random worlds") {
  const sortie::tests::WorldVerdict verdict = sortie::tests::euclidean_worlds(0, 120, 12);
  CHECK(verdict.ticks == 120 * 12);
  CHECK(verdict.wrong == 0);
  CHECK(verdict.not_current == 0);
  // The worlds are worth something: many segments, evictions, splits and merges.
  CHECK(verdict.most_segments > 200);
  CHECK(verdict.evicted > 10000);
  CHECK(verdict.cut > 100);
  CHECK(verdict.renamed > 100);
}
