// SPDX-License-Identifier: BSD-3-Clause
// Scene uav_hall, of which the vehicle is told nothing.
#include "tests/firmware_like/sensed_halls.hpp"

namespace sortie::testing {

TEST_CASE("uav_hall is flown there and back on a sensed map: doors, a window, a door that is shut under way",
          "[heavy]") {
  const TempFolder folder;
  const std::string file = folder.file("hall.toml");
  {
    std::ifstream scene(std::string(SORTIE_SCENES_DIR) + "/uav_hall.toml");
    std::ofstream out(file);
    out << scene.rdbuf();  // and a ceiling: what no ray comes back from stays unknown
    out << "\n[[world.boxes]]\nx_m = -2.0\ny_m = -4.0\nz_m = 3.0\nlength_m = 16.0\nwidth_m = 8.0\nheight_m = "
           "0.2\n";
  }
  const firmware::LiveRunOutcome run = fly_sensed(file, 60, {});
  const auto& counters = run.results.counters;
  CHECK(counters.at("goals_reached") == 2);
  CHECK(counters.at("ways_begun") >= 1);  // part of the way was unknown when it set out
  CHECK(counters.at("ways_hopeless") == 0);
  CHECK(counters.at("bench_collisions") == 0);
  CHECK(counters.at("bench_least_gap_mm") > 50);
}

}  // namespace sortie::testing
