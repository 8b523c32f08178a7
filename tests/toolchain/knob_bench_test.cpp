// SPDX-License-Identifier: BSD-3-Clause
// Knobs: each is a key that some scene reads, is tried within its range, and moves what it should move.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "firmware_like/scene/json.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/bench/knob_bench.hpp"

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

const KnobSweep& sweep_of(const std::vector<KnobSweep>& sweeps, const std::string& key) {
  const auto found = std::find_if(sweeps.begin(), sweeps.end(),
                                  [&key](const KnobSweep& knob) { return key == knob.trial.knob.key; });
  REQUIRE(found != sweeps.end());
  return *found;
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
  for (const BuiltInScene& scene : built_in_scenes()) {
    if (load_scene(scene.name).use().empty()) continue;
    for (const KnobTrial& trial : knob_trials(scene.name, {}, own_vehicles())) {
      INFO(scene.name << " " << trial.knob.key);
      seen.insert(std::string(trial.knob.part) + " " + trial.knob.key);
      CHECK(trial.tried.size() > 1);
      CHECK(std::any_of(trial.tried.begin(), trial.tried.end(),
                        [&](const std::string& value) { return same_value(value, trial.declared.value); }));
      CHECK_FALSE(trial.declared.meaning.empty());
      const std::string last = std::string(trial.knob.key) + "=" + trial.tried.back();
      CHECK_NOTHROW(Runtime(load_scene(scene.name, {last}), own_vehicles(), RuntimeStart{}));
    }
  }
  // Those that are off in every such scene begin at 0: there is nothing around it.
  const std::set<std::string> off{"map map.evict_blocks", "map map.forget_s"};
  for (const Knob& knob : algorithm_knobs()) {
    const std::string name = std::string(knob.part) + " " + knob.key;
    INFO(name);
    CHECK(seen.count(name) + off.count(name) == 1);
  }
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
  const KnobSet set{"hall", run.record, "ugv_hall", {"limits.voxels=32768"}, {}};
  const std::vector<KnobSweep> sweeps = sweep_knobs(set, own_vehicles(), 1, {});
  const Sweep& aid = sweep_of(sweeps, "attitude.track_aid").sweep;
  CHECK(aid.error == "inclination_rmse_deg");
  REQUIRE(aid.cells.size() == 2);
  CHECK(aid.cells[0].errors.at(aid.error) != aid.cells[1].errors.at(aid.error));
  const Sweep& voxel = sweep_of(sweeps, "map.voxel_m").sweep;
  CHECK(voxel.error == "map_disagreement");
  CHECK(voxel.cells.front().errors.at(voxel.error) < voxel.cells.back().errors.at(voxel.error));
  CHECK(aid.cells[0].memory_bytes * 5 < voxel.cells[0].memory_bytes);

  const Json rows = to_json("hall", sweeps);
  std::size_t cells = 0;
  std::set<std::string> names;
  for (const KnobSweep& knob : sweeps) cells += knob.sweep.cells.size();
  REQUIRE(rows.size() == cells);
  for (const auto& row : rows)
    names.insert(row["part"].get<std::string>() + row["knob"].get<std::string>() + row["value"].dump());
  CHECK(names.size() == cells);
  const std::string table = knob_table(sweeps);
  CHECK(table.find("`attitude.track_aid`: the tracks' acceleration is taken out") != std::string::npos);
  CHECK(plot_knobs("hall", sweeps).series.size() == 2);
}
