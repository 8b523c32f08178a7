// SPDX-License-Identifier: BSD-3-Clause
// A sweep of a log that began with the map of another run.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/firmware_like/kept_map_rig.hpp"
#include "toolchain/sweep/sweep.hpp"

namespace sortie::testing {

TEST_CASE("each cell of a sweep begins with the kept map, and is judged by where it places the robot",
          "[heavy]") {
  const TempFolder folder;
  const std::string map = folder.file("hall.surfels");
  const std::string path = folder.file("again.lcm");
  keep_map(located_hall().log, map);
  const firmware::LiveRunOutcome run =
      run_located(3, path, {"tasks.locate.enabled=true", "locate.start_on_map=true"}, map);
  const firmware::LogFile log(path);
  toolchain::SweepOptions options;
  options.knobs = toolchain::parse_knobs({"locate.returns=100,400"});
  options.replay.maps.map = map;
  const toolchain::Sweep sweep = toolchain::run_sweep(log, firmware::own_vehicles(), options);
  CHECK(sweep.error == "located_ate_rmse_m");
  CHECK(sweep.tasks == std::vector<std::string>{"locate"});
  REQUIRE(sweep.cells.size() == 3);  // the two, and the profile's own
  CHECK(sweep.cells[2].profile_choice);
  CHECK(sweep.cells[2].digest == run.results.digest);
  CHECK(sweep.cells[0].errors.at("located_ate_rmse_m") != sweep.cells[1].errors.at("located_ate_rmse_m"));
  for (const toolchain::SweepCell& cell : sweep.cells) {
    CHECK(cell.errors.at("located_ate_max_m") < 0.1);
    CHECK(cell.errors.at("ate_rmse_m") == sweep.cells[0].errors.at("ate_rmse_m"));  // the odometry's
  }
  options.replay.maps.map.clear();
  const std::string refused = message_of<firmware::ProfileError>(
      [&] { static_cast<void>(toolchain::run_sweep(log, firmware::own_vehicles(), options)); });
  CHECK(mentions(refused, "begins with the map hall.surfels"));
  CHECK(mentions(refused, "--map FILE"));
}

}  // namespace sortie::testing
