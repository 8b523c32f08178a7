// SPDX-License-Identifier: BSD-3-Clause
// What docs/registration.md shows: the map of a whole mission, and a robot that is lost on it.
#include <catch2/catch.hpp>

#include "tests/firmware_like/kept_map_rig.hpp"

using namespace sortie;
using namespace sortie::testing;

namespace {
firmware::LiveRunOutcome run_mission(double seconds, const std::string& log, const std::string& map) {
  firmware::LiveRunOptions options;
  options.scene = "ugv_locate";
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.map = map;
  options.lcm_url = "none";
  firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  static_cast<void>(toolchain::judge(run));
  return run;
}
}  // namespace

TEST_CASE("The map of the whole mission fits its own scene, and a robot that is lost on it is placed") {
  const TempFolder folder;
  const std::string log = folder.file("mission.lcm"), map = folder.file("hall.surfels");
  static_cast<void>(run_mission(165, log, ""));
  static_cast<void>(keep_map(log, map));
  const firmware::LiveRunOutcome run = run_mission(100, "", map);
  CHECK(run.failures.empty());
  CHECK(counted(run, "relocate_placed") >= 2);
  CHECK(counted(run, "relocate_not_confirmed") == 0);
  CHECK(counted(run, "locate_accepted") > 0);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.3);  // the mission's own drift, which the map has
}
