// SPDX-License-Identifier: BSD-3-Clause
// `sortie scenes --cost` and `--advise` over short drives.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "firmware_like/bench/part_sizes.hpp"
#include "firmware_like/bench/scene_advice.hpp"
#include "firmware_like/bench/scene_cost.hpp"
#include "firmware_like/json.hpp"
#include "firmware_like/scene_parts.hpp"
#include "firmware_like/telemetry.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::testing;

namespace {

const PartCost& part_of(const SceneCosts& costs, const std::string& name) {
  const auto found = std::find_if(costs.without.begin(), costs.without.end(),
                                  [&name](const PartCost& line) { return line.part == name; });
  REQUIRE(found != costs.without.end());
  return *found;
}

const AdviceLine& advice_on(const Advice& advice, const std::string& name) {
  const auto found = std::find_if(advice.lines.begin(), advice.lines.end(),
                                  [&name](const AdviceLine& line) { return line.part == name; });
  REQUIRE(found != advice.lines.end());
  return *found;
}

void drive(const std::string& scene, double seconds, const std::vector<std::string>& overrides,
           const std::string& record) {
  LiveRunOptions run;
  run.scene = scene;
  run.seconds = seconds;
  run.overrides = overrides;
  run.virtual_time = true;
  run.lcm_url = "none";
  run.record = record;
  static_cast<void>(run_live(own_vehicles(), make_own_bench, run));
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
  const SceneCosts costs = measure_scene_cost(own_vehicles(), make_own_bench, small_hall());
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
  const SceneCosts costs = measure_scene_cost(own_vehicles(), make_own_bench, options);
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
  costs.whole.program_bytes = 90000;
  costs.whole.us_per_tick = 2;
  costs.whole.errors = {{"ate_rmse_m", 0.25}};
  costs.without.push_back(
      {"map", "a map", "", {1000, 70000, 0.5, 0.5, 0.5, 0, {{"ate_rmse_m", 0.75}}, {}, 0}});
  costs.without.push_back({"drive", "a drive", "drive is needed by flippers: leave that out first", {}});
  const auto object = to_json(costs);
  CHECK(object["without"][0]["saves_bytes"] == 2000);
  CHECK(object["without"][0]["program_bytes"] == 70000);
  CHECK(object["without"][0]["saves_us_per_tick"] == 1.5);
  CHECK(object["without"][0]["errors"]["ate_rmse_m"] == 0.75);
  CHECK(object["without"][1]["refused"] == "drive is needed by flippers: leave that out first");
  CHECK_FALSE(object["without"][1].contains("bytes"));
  const std::string table = scene_cost_table(costs);
  for (const char* words : {"(nothing)", "3000", "90000", "70000", "0.2500", "0.7500",
                            "stays: drive: drive is needed by flippers"})
    CHECK(table.find(words) != std::string::npos);
}

TEST_CASE("programs that were built without a part belong to scenes that have it, and are smaller for it") {
  CHECK(program_bytes("ugv_hall", "") > 0);
  for (const PartSize& size : part_sizes()) {
    INFO(size.scene << " without " << size.without);
    const auto parts = parts_of(load_scene(size.scene));
    if (*size.without == '\0') continue;
    const std::string without = size.without;  // "odometry+drive": what stands on it, too
    const ScenePart* part = find_scene_part(without.substr(0, without.find('+')));
    REQUIRE(part != nullptr);
    CHECK(part->code != rt::Part::count);
    CHECK(std::find(parts.begin(), parts.end(), part) != parts.end());
    CHECK(joined_names(with_dependants(*part, parts)) == without);
    CHECK(size.bytes < program_bytes(size.scene, ""));
  }
  CHECK(program_bytes("ugv_hall", "track_aid") == program_bytes("ugv_hall", ""));  // shares its parent's code
  CHECK(program_bytes("no such scene", "") == 0);
}

TEST_CASE("a scene without a simulated robot needs a log for its costs") {
  SceneCostOptions options;
  options.scene = "imu_bench";
  CHECK_THROWS_WITH(measure_scene_cost(own_vehicles(), make_own_bench, options),
                    Catch::Contains("imu_bench has no simulated robot: give --log LOG"));
}

TEST_CASE("advice names a map that nobody read, and keeps quiet about what acts") {
  const TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  drive("ugv_hall", 3, small_hall().overrides, log);
  const Advice advice = advise(LogFile(log), own_vehicles(), {});
  CHECK(advice.judged_by == "ate_rmse_m");
  const AdviceLine& map = advice_on(advice, "map");
  CHECK(map.verdict == PartVerdict::never_mattered);
  CHECK(map.figure.find("the pose moves by up to 0 m") != std::string::npos);
  CHECK(map.pose_moved_m == 0.0);
  CHECK(map.bytes > 1'000'000);
  CHECK(advice_on(advice, "segment_lists").figure.find("0 of the ") == 0);
  CHECK(advice_on(advice, "segments").figure.find("map put out something else; ") == 0);
  CHECK(advice_on(advice, "drive").verdict == PartVerdict::not_judged);
  CHECK(advice_text(advice).find("never mattered") != std::string::npos);
  CHECK(to_json(advice)["parts"].size() == advice.lines.size());
}

TEST_CASE("on stairs the obstacle models matter, and are missed where they are off", "[heavy]") {
  const TempFolder folder;
  const std::string with = folder.file("with.lcm");
  const std::string without = folder.file("without.lcm");
  drive("ugv_stairs", 19, {}, with);
  drive("ugv_stairs", 19, {"odometry.obstacles=off"}, without);

  const Advice has = advise(LogFile(with), own_vehicles(), {});
  const AdviceLine& mattered = advice_on(has, "obstacles");
  CHECK(mattered.verdict == PartVerdict::mattered);
  CHECK(has.most_inclined_deg > 20);

  const Advice lacks = advise(LogFile(without), own_vehicles(), {});
  const AdviceLine& missed = advice_on(lacks, "obstacles");
  CHECK(missed.verdict == PartVerdict::would_matter);
  REQUIRE(missed.error.has_value());
  REQUIRE(missed.changed.has_value());
  CHECK(*missed.changed < 0.8 * *missed.error);
  CHECK(missed.figure.find("inclined by up to ") == 0);
  // The plane is what they are for in vain: the same question has the other answer there.
  const std::string flat = folder.file("flat.lcm");
  drive("ugv_straight", 8, {"odometry.obstacles=off"}, flat);
  CHECK(advice_on(advise(LogFile(flat), own_vehicles(), {}), "obstacles").verdict == PartVerdict::would_not);
}
