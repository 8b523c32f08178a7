// SPDX-License-Identifier: BSD-3-Clause
// Mazes, walls with one hole and loose blocks: a way whenever there is one, and it is safe.
#include "tests/planner/path_maps.hpp"

TEST_CASE("uav path: in 36 mazes, walls with one hole and blocks there is a way exactly where one can be") {
  sortie::planner::test::MapTally tally;
  for (std::uint32_t n = 0; n < 36; ++n) sortie::planner::test::judge_map(4000, n, tally);
  CHECK(tally.ways > 12);
  CHECK(tally.walls > 3);
}
