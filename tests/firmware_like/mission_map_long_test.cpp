// SPDX-License-Identifier: BSD-3-Clause
// What docs/registration.md shows: the map of a whole mission, and a robot that is lost on it.
#include <catch2/catch.hpp>

#include "tests/firmware_like/kept_map_rig.hpp"

using namespace sortie;
using namespace sortie::testing;

TEST_CASE("The map of the whole mission fits its own scene, and a robot that is lost on it is placed") {
  const TempFolder folder;
  const std::string log = folder.file("mission.lcm"), map = folder.file("hall.surfels");
  static_cast<void>(run_virtually("ugv_locate", {}, 165, log, ""));
  static_cast<void>(keep_map(log, map));
  const firmware::LiveRunOutcome run = run_virtually("ugv_locate", {}, 100, "", map);
  CHECK(run.failures.empty());
  CHECK(counted(run, "relocate_placed") >= 2);
  CHECK(counted(run, "relocate_not_confirmed") == 0);
  CHECK(counted(run, "locate_accepted") > 0);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.3);  // on a map of the first mission, drift and all
}
