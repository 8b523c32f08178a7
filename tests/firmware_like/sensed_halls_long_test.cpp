// SPDX-License-Identifier: BSD-3-Clause
// Many halls, each with other noise of the sensors.
#include <iostream>

#include "tests/firmware_like/sensed_halls.hpp"

namespace sortie::testing {

TEST_CASE("In 24 halls drawn at random both goals are reached on a sensed map, and nothing is touched",
          "[long]") {
  std::uint64_t least_mm = UINT64_MAX;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const RandomHall hall = draw_hall(seed);
    const firmware::LiveRunOutcome run =
        fly_sensed("uav_hall", 90, {world_boxes(hall.boxes), hall.goals, "hil.seed=" + std::to_string(seed)});
    const auto& counters = run.results.counters;
    INFO("seed " << seed << ", " << world_boxes(hall.boxes) << ", " << hall.goals);
    CHECK(counters.at("goals_reached") == 2);
    CHECK(counters.at("bench_collisions") == 0);
    CHECK_FALSE(met_a_box(run, hall.boxes));
    least_mm = std::min(least_mm, counters.at("bench_least_gap_mm"));
    std::cout << "hall " << seed << ": goals " << counters.at("goals_reached") << ", without way "
              << counters.at("goals_without_way") << ", hopeless " << counters.at("ways_hopeless")
              << ", backed off " << counters.at("ways_backed_off") << ", least gap "
              << counters.at("bench_least_gap_mm") << " mm" << std::endl;  // one hall takes ten seconds
  }
  std::cout << "least distance of the rotors' rims to a box: " << least_mm << " mm\n";
}

}  // namespace sortie::testing
