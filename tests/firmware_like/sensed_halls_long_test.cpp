// SPDX-License-Identifier: BSD-3-Clause
// Many halls, each with other noise of the sensors.
#include <iostream>

#include "tests/firmware_like/sensed_halls.hpp"

namespace sortie::testing {

TEST_CASE("In 24 halls drawn at random both goals are reached on a sensed map, and nothing is touched",
          "[long]") {
  double least_m = 1e9;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const RandomHall hall = draw_hall(seed);
    const firmware::LiveRunOutcome run =
        fly_sensed("uav_hall", 120, {hall.text(), hall.goals, "hil.seed=" + std::to_string(seed)});
    const auto& counters = run.results.counters;
    const double gap_m = least_gap_m(run, hall.boxes);
    INFO("seed " << seed << ", " << hall.text() << ", " << hall.goals << ", gap " << gap_m << " m");
    CHECK(counters.at("goals_reached") == 2);
    CHECK(counters.at("bench_collisions") == 0);
    CHECK(gap_m > 0.0);
    least_m = std::min(least_m, gap_m);
    std::cout << "hall " << seed << ": goals " << counters.at("goals_reached") << ", without way "
              << counters.at("goals_without_way") << ", hopeless " << counters.at("ways_hopeless") << ", gap "
              << gap_m << " m\n";
  }
  std::cout << "least gap of the vehicle to a box: " << least_m << " m\n";
}

}  // namespace sortie::testing
