// SPDX-License-Identifier: BSD-3-Clause
// Vehicles that look for their place on a ground robot's cloud: how many are placed, and none wrongly.
#include <catch2/catch.hpp>

#include "tests/firmware_like/depot_rig.hpp"

TEST_CASE("Vehicles find their place on a ground robot's cloud from another frame, and fly by its map") {
  using namespace sortie::testing;
  const TempFolder folder;
  const std::string map = folder.file("depot.cloud");
  keep_ground_cloud(map);
  std::uint32_t placed = 0;
  const std::uint32_t seeds = 4;
  for (std::uint32_t seed = 11; seed < 11 + seeds; ++seed) placed += flies_by_cloud(map, seed) ? 1 : 0;
  WARN(placed << " of " << seeds << " placed");
  CHECK(placed > 0);
}
