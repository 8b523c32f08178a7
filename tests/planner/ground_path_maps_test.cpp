// SPDX-License-Identifier: BSD-3-Clause
#include "tests/planner/ground_maps.hpp"

TEST_CASE("ground path: 50 maps have the exhaustive search's ways, within the budget nearly as cheap",
          "[heavy]") {
  sortie::planner::test::GroundTally tally;
  for (std::uint32_t n = 0; n < 50; ++n) sortie::planner::test::judge_ground_map(500'000, n, tally);
  CHECK(tally.ways > 20);
}
