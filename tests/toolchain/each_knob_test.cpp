// SPDX-License-Identifier: BSD-3-Clause
// Knobs: each is a key that some scene reads, is tried within its range, and moves what it should move.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "tests/firmware_like/ladder_vehicle.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/sweep/sweep_plan.hpp"
#include "toolchain/sweep/sweep_set.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

ProfileKey number_key(const std::string& value, double number, double low, double high) {
  ProfileKey key;
  key.value = value;
  key.number = number;
  key.low = low;
  key.high = high;
  return key;
}

const SweepOptions& sweep_of(const std::vector<SweepOptions>& sweeps, const std::string& key) {
  const auto found = std::find_if(sweeps.begin(), sweeps.end(),
                                  [&key](const SweepOptions& one) { return one.knobs.front().key == key; });
  REQUIRE(found != sweeps.end());
  return *found;
}

SceneBuilder builder_of(const std::string& scene) {
  return [scene](const std::vector<std::string>& overrides) {
    return std::make_unique<Runtime>(load_scene(scene, overrides), own_vehicles(), RuntimeStart{});
  };
}

}  // namespace

TEST_CASE("a number is tried around what it is, within its range, and a choice at all it may be") {
  using Values = std::vector<std::string>;
  CHECK(knob_values(number_key("0.1", 0.1, 0.01, 10)) == Values{"0.025", "0.05", "0.1", "0.2", "0.4"});
  CHECK(knob_values(number_key("8", 8, 5, 20)) == Values{"8", "16"});
  CHECK(knob_values(number_key("0", 0, 0, 5)) == Values{"0"});  // nothing to try
  ProfileKey choice;
  choice.value = "\"mean\"";
  choice.range = "mean, point";
  CHECK(knob_values(choice) == Values{"\"mean\"", "\"point\""});
  choice.value = "true";
  choice.range = "true, false";
  CHECK(knob_values(choice) == Values{"true", "false"});
}

TEST_CASE("every knob is read by some scene for real use, and every value that is tried can be built") {
  std::set<std::string> seen;
  std::set<std::string> marked;
  for (const BuiltInScene& scene : built_in_scenes()) {
    const Runtime any(load_scene(scene.name), own_vehicles(), RuntimeStart{});
    for (const ProfileKey& key : any.profile().keys()) {
      if (key.is_knob) marked.insert(any.profile().vehicle() + " " + key.path);
    }
    if (load_scene(scene.name).use().empty()) continue;
    const SceneBuilder build = builder_of(scene.name);
    const auto own = build({});
    for (const SweepOptions& one : each_knob_alone(build, {})) {
      REQUIRE(one.knobs.size() == 1);
      const SweepKnob& knob = one.knobs.front();
      INFO(scene.name << " " << knob.key);
      seen.insert(own->profile().vehicle() + " " + knob.key);
      CHECK(knob.values.size() > 1);
      const auto& keys = own->profile().keys();
      const auto declared = std::find_if(keys.begin(), keys.end(),
                                         [&knob](const ProfileKey& key) { return key.path == knob.key; });
      REQUIRE(declared != keys.end());
      CHECK(std::any_of(knob.values.begin(), knob.values.end(),
                        [&](const std::string& value) { return same_value(value, declared->value); }));
      CHECK_FALSE(std::string(declared->meaning).empty());
      CHECK_NOTHROW(build({knob.key + "=" + knob.values.front()}));
      CHECK_NOTHROW(build({knob.key + "=" + knob.values.back()}));
    }
  }
  // Those that are off in every such scene begin at 0: there is nothing around it.
  const std::set<std::string> off{"ugv map.evict_blocks", "ugv map.forget_s"};
  for (const std::string& knob : marked) {
    INFO(knob);
    CHECK(seen.count(knob) + off.count(knob) == 1);
  }
  CHECK(marked.size() == 33);  // a mark that is lost is noticed
}

TEST_CASE("a vehicle of one's own without a knob has nothing to sweep") {
  const auto build = [](const std::vector<std::string>& overrides) {
    return std::make_unique<Runtime>(
        Profile("scene.name = \"steps\"\nscene.vehicle = \"ladder\"\n", "steps", overrides),
        ladder_vehicles(), RuntimeStart{});
  };
  CHECK_THROWS_WITH(each_knob_alone(build, {}), Catch::Contains("--sweep knobs: scene steps has none"));
}

TEST_CASE("a knob alone moves its own error, and the map is left out where it is not the map's") {
  const TempFolder folder;
  LiveRunOptions run;
  run.scene = "ugv_hall";
  run.overrides = {"hil.lidar_rows=8", "hil.lidar_columns=64", "limits.voxels=32768"};
  run.seconds = 3;
  run.virtual_time = true;
  run.lcm_url = "none";
  run.record = folder.file("hall.lcm");
  static_cast<void>(run_live(own_vehicles(), make_simulated_robot, run));
  const LogFile log(run.record);
  SweepOptions all;
  all.each_knob = true;
  const std::vector<SweepOptions> sweeps = sweeps_of(log, own_vehicles(), all);
  const Sweep aid = run_sweep(log, own_vehicles(), sweep_of(sweeps, "attitude.track_aid"));
  CHECK(aid.error == "inclination_rmse_deg");
  REQUIRE(aid.cells.size() == 2);
  CHECK(aid.cells[0].errors.at(aid.error) != aid.cells[1].errors.at(aid.error));
  const Sweep voxel = run_sweep(log, own_vehicles(), sweep_of(sweeps, "map.voxel_m"));
  CHECK(voxel.error == "map_disagreement");
  CHECK(voxel.cells.front().errors.at(voxel.error) < voxel.cells.back().errors.at(voxel.error));
  CHECK(aid.cells[0].voxels == 0);
  CHECK(voxel.cells[0].voxels > 0);
  // Its tasks are the map's, but its name does not say so.
  CHECK(sweep_of(sweeps, "groups.mapping.rate_hz").error == "map_disagreement");
  all.error = "ate_rmse_m";
  CHECK(sweep_of(sweeps_of(log, own_vehicles(), all), "map.voxel_m").error == "ate_rmse_m");

  const SweepSet set = make_sweep_set({{run.record, aid}, {run.record, voxel}});
  CHECK((set.spread.empty() && set.warnings.empty() && set.error.empty()));
  const std::string page = sweep_page(set, "sortie bench --sweep knobs");
  CHECK_THAT(page, Catch::Contains("Written by `sortie bench --sweep knobs`") &&
                       Catch::Contains("## attitude.track_aid, ugv_hall") &&
                       Catch::Contains("(sweep-2.svg)") &&
                       Catch::Contains("\n| " + voxel.cells[1].values[0] + " | "));
}
