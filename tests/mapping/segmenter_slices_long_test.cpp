// SPDX-License-Identifier: BSD-3-Clause
// A million steps of sliced worlds, and as many of worlds that nobody has seen before.
#include <catch2/catch.hpp>
#include <random>

#include "tests/mapping/segmenter_slices.hpp"

TEST_CASE(
    "Wherever a budget stops it, in a thousand worlds: the segmenter comes to the partition of brute force") {
  const std::uint32_t seed = std::random_device{}();
  for (const std::uint32_t first : {1000u, seed}) {
    INFO("worlds from " << first);
    const sortie::tests::SliceVerdict verdict = sortie::tests::sliced_worlds(first, 1000, 1000);
    CHECK(verdict.fault == "");
    CHECK(verdict.steps == 1000000);
    CHECK(verdict.apart_left > 100);
    CHECK(verdict.healed > 1000);
    CHECK(verdict.resumed_labelling > 1000);
  }
}
