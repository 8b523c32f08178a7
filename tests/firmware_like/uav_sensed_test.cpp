// SPDX-License-Identifier: BSD-3-Clause
// The first seconds on a sensed map.
#include "tests/firmware_like/sensed_room.hpp"

namespace sortie::testing {

TEST_CASE("A map of what the lidar saw is the same in a replay and from a keyframe", "[heavy]") {
  const auto counters = fly_sensed_room(5, {"2.0", "4.0"});
  CHECK(counters.at("bench_collisions") == 0);
  CHECK(counters.at("occupancy_used") > 1000);
}

}  // namespace sortie::testing
