// SPDX-License-Identifier: BSD-3-Clause
// Scenes that tell nobody, or that are not recorded: the same outputs, and a word where one is asked for
// more.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "firmware_like/log/replay.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

LiveRunOptions short_run(const std::vector<std::string>& more, bool is_virtual) {
  LiveRunOptions run;
  run.scene = "ugv_hall";
  run.overrides = {"hil.lidar_rows=8", "hil.lidar_columns=64"};
  run.overrides.insert(run.overrides.end(), more.begin(), more.end());
  run.seconds = 1;
  run.virtual_time = is_virtual;
  run.realtime = false;
  run.lcm_url = "none";
  return run;
}

bool lists(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

TEST_CASE("a scene without telemetry and recorder puts out the same") {
  const LiveRunOutcome both = run_live(own_vehicles(), make_simulated_robot, short_run({}, true));
  const LiveRunOutcome none = run_live(own_vehicles(), make_simulated_robot,
                                       short_run({"live.telemetry=false", "live.recorder=false"}, true));
  CHECK(none.results.digest == both.results.digest);
  CHECK(none.results.ticks == both.results.ticks);
  CHECK(both.results.counters.count("lcm_published") == 1);
  CHECK(none.results.counters.count("lcm_published") == 0);
  CHECK_FALSE(lists(both.results.left_out, "telemetry"));
  CHECK(lists(none.results.left_out, "telemetry"));
  CHECK(lists(none.results.left_out, "recorder"));
}

TEST_CASE("a live run without telemetry tells nobody, though an address was given") {
  const TempFolder folder;
  const std::string told = folder.file("told.lcm");
  for (const bool telemetry : {true, false}) {
    LiveRunOptions run = short_run({std::string("live.telemetry=") + (telemetry ? "true" : "false")}, false);
    run.lcm_url = "file://" + told + "?mode=w";
    std::filesystem::remove(told);
    const LiveRunOutcome outcome = run_live(own_vehicles(), make_simulated_robot, run);
    INFO("telemetry " << telemetry);
    CHECK(std::filesystem::exists(told) == telemetry);
    CHECK(outcome.results.counters.count("telemetry_cpu_us") == (telemetry ? 1u : 0u));
    CHECK(outcome.results.counters.at("recorder_cpu_us") > 0);
  }
}

TEST_CASE("a scene that is not recorded says so before it runs, with the cure") {
  const TempFolder folder;
  LiveRunOptions run = short_run({"live.recorder=false"}, true);
  run.record = folder.file("run.lcm");
  CHECK_THROWS_WITH(
      run_live(own_vehicles(), make_simulated_robot, run),
      "live.recorder = false in ugv_hall: it is not recorded; leave out --record, or take --set "
      "live.recorder=true");
  CHECK_FALSE(std::filesystem::exists(run.record));

  run = short_run({}, true);
  run.record = folder.file("good.lcm");
  static_cast<void>(run_live(own_vehicles(), make_simulated_robot, run));
  ReplayOptions again;
  again.overrides = {"live.recorder=false"};
  again.record = folder.file("again.lcm");
  CHECK_THROWS_AS(replay(LogFile(run.record), own_vehicles(), again), ProfileError);
}
