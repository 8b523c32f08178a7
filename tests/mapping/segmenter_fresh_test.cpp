// SPDX-License-Identifier: BSD-3-Clause
#include <catch2/catch.hpp>

#include "tests/mapping/fresh_segmenter.hpp"

TEST_CASE("A segmenter that kept up with a drive says what a fresh one says", "[heavy]") {
  using namespace sortie;
  for (std::uint32_t seed = 20; seed < 24; ++seed) {
    INFO("seed " << seed);
    const tests::FreshVerdict near = tests::wavering_drive(seed, mapping::EuclideanPolicy{});
    CHECK(near.cores > 100000);
    CHECK(near.differing == 0);
    for (const double angle_rad : {0.07, 0.2}) {
      INFO("angle " << angle_rad);
      const tests::FreshVerdict smooth =
          tests::wavering_drive(seed, mapping::SmoothnessPolicy(angle_rad, angle_rad < 0.1 ? 0.05 : 0.1));
      CHECK(smooth.cores > 20000);
      CHECK(smooth.differing == 0);
    }
  }
}
