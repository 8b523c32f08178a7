// SPDX-License-Identifier: BSD-3-Clause
// The same in a thousand maps.
#include "tests/planner/path_maps.hpp"

TEST_CASE("uav path: in 1000 mazes, walls with one hole and blocks there is a way exactly where one can be",
          "[long]") {
  sortie::planner::test::MapTally tally;
  for (std::uint32_t n = 0; n < 1000; ++n) sortie::planner::test::judge_map(70000, n, tally);
  CAPTURE(tally.ways, tally.walls);
  CHECK(tally.ways > 400);
  CHECK(tally.walls > 100);
}
