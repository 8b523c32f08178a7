// SPDX-License-Identifier: BSD-3-Clause
#include "tests/planner/ground_maps.hpp"

TEST_CASE("ground path: 1000 maps have the exhaustive search's ways, within the budget nearly as cheap",
          "[long]") {
  sortie::planner::test::GroundTally tally;
  for (std::uint32_t n = 0; n < 1000; ++n) sortie::planner::test::judge_ground_map(600'000, n, tally);
  WARN(tally.ways << " ways, " << tally.walls << " without, " << tally.refused << " refused; worst at "
                  << sortie::planner::test::kGroundBudget << " units " << tally.worst_at_budget);
  CHECK(tally.ways > 400);
  CHECK(tally.walls > 20);
}
