// SPDX-License-Identifier: BSD-3-Clause
// `sortie scenes --cost` over short drives.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "firmware_like/link/telemetry.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/bench/scene_cost.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

const PartCost& part_of(const SceneCosts& costs, const std::string& name) {
  const auto found = std::find_if(costs.without.begin(), costs.without.end(),
                                  [&name](const PartCost& line) { return line.part == name; });
  REQUIRE(found != costs.without.end());
  return *found;
}

SceneCostOptions small_hall() {
  SceneCostOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=8", "hil.lidar_columns=128", "limits.voxels=32768"};
  options.seconds = 3;
  options.runs = 1;
  return options;
}

}  // namespace

TEST_CASE("the cost of each part is that of a run without it") {
  const SceneCosts costs = measure_scene_cost(own_vehicles(), make_simulated_robot, small_hall());
  CHECK(costs.ticks == 3000);
  CHECK(costs.whole.us_per_tick > 0);
  CHECK(costs.whole.errors.at("ate_n") > 100);
  const PartCost& map = part_of(costs, "map");
  CHECK(map.refused.empty());
  CHECK(costs.whole.bytes - map.cost.bytes > 2'000'000);
  CHECK(map.cost.errors == costs.whole.errors);  // the pose does not come from the map
  CHECK(map.cost.end_off_m == 0.0);
  const PartCost& segments = part_of(costs, "segments");
  CHECK(segments.cost.bytes < costs.whole.bytes);
  CHECK(segments.cost.bytes > map.cost.bytes);
  // Without the drive nothing moves, where a replay of the same inputs sees no difference.
  const PartCost& stands = part_of(costs, "drive");
  CHECK(stands.cost.errors == costs.whole.errors);
  CHECK(stands.cost.driven != costs.whole.errors);
  CHECK(stands.cost.end_off_m > 0.01);
  // What stands on a part goes with it.
  const PartCost& blind = part_of(costs, "attitude+odometry+drive");
  CHECK(blind.refused.empty());
  CHECK(blind.cost.errors.empty());
  CHECK(blind.cost.bytes < stands.cost.bytes);
  // What tells the outside is no task: it saves memory, and its time is that of its threads in a live drive.
  const PartCost& mute = part_of(costs, "telemetry");
  CHECK(mute.is_outlet);
  CHECK(costs.whole.bytes - mute.cost.bytes == Telemetry::bytes());
  CHECK(mute.cost.errors == costs.whole.errors);
  CHECK(part_of(costs, "recorder").cost.bytes < costs.whole.bytes);
  CHECK_FALSE(costs.has_live);
  CHECK_FALSE(to_json(costs)["without"].back().contains("us_per_tick"));
  CHECK(part_of(costs, "track_aid").cost.errors != costs.whole.errors);
}

TEST_CASE("a live drive shows what the threads of recorder and telemetry take") {
  const TempFolder folder;
  SceneCostOptions options = small_hall();
  options.seconds = 0.2;
  options.live_s = 1;
  options.lcm_url = "file://" + folder.file("told.lcm") + "?mode=w";
  const SceneCosts costs = measure_scene_cost(own_vehicles(), make_simulated_robot, options);
  REQUIRE(costs.has_live);
  CHECK(costs.recorder_us > 0);
  CHECK(costs.telemetry_us > 0);
  CHECK(part_of(costs, "telemetry").cost.us_per_tick ==
        Approx(costs.whole.us_per_tick - costs.telemetry_us).epsilon(1e-9));
  CHECK(part_of(costs, "recorder").cost.us_per_tick ==
        Approx(costs.whole.us_per_tick - costs.recorder_us).epsilon(1e-9));
  CHECK(scene_cost_table(costs).find("took in a live drive") != std::string::npos);
}

TEST_CASE("costs as an object and as a table say the same") {
  SceneCosts costs;
  costs.scene = "a";
  costs.ticks = 10;
  costs.whole.bytes = 3000;
  costs.whole.us_per_tick = 2;
  costs.whole.errors = {{"ate_rmse_m", 0.25}};
  costs.without.push_back({"map", "a map", "", {1000, 0.5, 0.5, 0.5, 0, {{"ate_rmse_m", 0.75}}, {}, 0}});
  costs.without.push_back({"drive", "a drive", "drive is needed by flippers: leave that out first", {}});
  const auto object = to_json(costs);
  CHECK(object["without"][0]["saves_bytes"] == 2000);
  CHECK(object["without"][0]["saves_us_per_tick"] == 1.5);
  CHECK(object["without"][0]["errors"]["ate_rmse_m"] == 0.75);
  CHECK(object["without"][1]["refused"] == "drive is needed by flippers: leave that out first");
  CHECK_FALSE(object["without"][1].contains("bytes"));
  const std::string table = scene_cost_table(costs);
  for (const char* words :
       {"(nothing)", "3000", "0.2500", "0.7500", "stays: drive: drive is needed by flippers"})
    CHECK(table.find(words) != std::string::npos);
}

TEST_CASE("a scene without a simulated robot needs a log for its costs") {
  SceneCostOptions options;
  options.scene = "imu_bench";
  CHECK_THROWS_WITH(measure_scene_cost(own_vehicles(), make_simulated_robot, options),
                    Catch::Contains("imu_bench has no simulated robot: give --log LOG"));
}
