// SPDX-License-Identifier: BSD-3-Clause
// The whole flight on a sensed map.
#include "tests/firmware_like/sensed_room.hpp"

namespace sortie::testing {

TEST_CASE("A place behind a wall that was never told of is reached, and the ellipsoid never meets a box",
          "[long]") {
  const auto counters = fly_sensed_room(30, {"2.0", "6.0", "12.0"});
  CHECK(counters.at("goals_reached") == 1);
  CHECK(counters.at("ways_begun") >= 1);  // part of the way was unknown when it set out
  CHECK(counters.at("bench_collisions") == 0);
}

TEST_CASE(
    "A box that comes up on the way is seen, the way is given up, another is found, and nothing is touched",
    "[long]") {
  const auto counters = fly_sensed_room(35, {"6.5", "8.0"}, true);
  CHECK(counters.at("ways_given_up") >= 1);
  CHECK(counters.at("goals_reached") == 1);
  CHECK(counters.at("bench_collisions") == 0);
}

}  // namespace sortie::testing
