// SPDX-License-Identifier: BSD-3-Clause
// A run that used nothing of a stream has the wrong scene or a wrong sensor, and says so.
#include "firmware_like/log/stream_use.hpp"

#include <catch2/catch.hpp>

#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// The vehicle of the stalls, whose tasks say that they could use none of their samples.
VehicleRegistry idle_vehicles() {
  return {{"stall", [](VehicleBuilder& builder) -> std::unique_ptr<Vehicle> {
             auto vehicle = std::make_unique<StallVehicle>(builder);
             builder.uses("SORTIE_CUSTOM_fast", [] { return std::uint64_t{0}; });
             builder.uses("SORTIE_CUSTOM_slow", [] { return std::uint64_t{1}; });
             return vehicle;
           }}};
}

}  // namespace

TEST_CASE("a replay whose stream refuses every sample fails and says how many") {
  ReplayOptions options;
  options.overrides = {"limits.scan_points=16"};
  const ReplayOutcome outcome = replay_log(two_seconds().log, options);
  REQUIRE(outcome.failures.size() == 1);
  INFO(outcome.failures[0]);
  const std::string scans = std::to_string(LogFile(two_seconds().log).channel("SCAN").size());
  CHECK(mentions(outcome.failures[0], "channel SCAN: " + scans + " of " + scans +
                                          " samples were refused by scene ugv_hall (" + scans));
  CHECK(mentions(outcome.failures[0], "larger than its [limits] allow"));
  CHECK(mentions(outcome.results.warnings, outcome.failures[0]));
  CHECK(replay_log(two_seconds().log).failures.empty());
  CHECK(two_seconds().run.failures.empty());
}

TEST_CASE("a replay with a scene that has none of the log's streams fails") {
  ReplayOptions options;
  options.scene = "uav_gusts";
  const TempFolder folder;
  const std::string only_scans = folder.file("scans.lcm");
  rewrite_log(two_seconds().log, only_scans,
              [](EditableEvent& event, std::size_t) { return event.channel != "IMU"; });
  const ReplayOutcome outcome = replay_log(only_scans, options);
  REQUIRE_FALSE(outcome.failures.empty());
  INFO(outcome.failures[0]);
  CHECK(outcome.failures.size() == 2);
  CHECK(mentions(outcome.failures, "channel SCAN: no task of scene uav_gusts takes it"));
  CHECK(mentions(outcome.failures, "channel TRACK: no task of scene uav_gusts takes it"));
  CHECK(mentions(outcome.results.warnings, outcome.failures[0]));
  options.accept_unused = true;
  CHECK(replay_log(only_scans, options).failures.empty());
  // A what-if that leaves something out uses the rest.
  ReplayOptions what_if;
  what_if.scene = "ugv_straight";
  CHECK(replay_log(two_seconds().log, what_if).failures.empty());
}

TEST_CASE("samples that no job has seen yet are not called unused") {
  const TempFolder folder;
  Runtime runtime(load_scene(stall_scene(folder)), idle_vehicles(), RuntimeStart{});
  for (int i = 0; i < 100; ++i) runtime.vehicle().poll_devices({}, i);  // 64 wait, and no job runs any more
  for (const StreamUse& use : pushed_streams(runtime)) {
    CHECK(use.there == 100);
    CHECK(use.taken == 0);
  }
  CHECK(unused_streams(runtime, pushed_streams(runtime), false).empty());
}

TEST_CASE("a stream whose samples no task could use fails the run and its replay") {
  const TempFolder folder;
  stalls = {};
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.seconds = 0.3;
  options.realtime = false;
  options.record = folder.file("live.lcm");
  options.lcm_url = "none";
  const LiveRunOutcome run = run_live(idle_vehicles(), nullptr, options);
  REQUIRE(run.failures.size() == 1);
  INFO(run.failures[0]);
  CHECK(mentions(run.failures[0], "channel SORTIE_CUSTOM_fast: scene stall took "));
  CHECK(mentions(run.failures[0], "its tasks could use none of them"));
  const LogFile log(options.record);
  CHECK(replay(log, idle_vehicles(), {}).failures.size() == 1);
  CHECK(replay(log, stall_vehicles(), {}).failures.empty());
}
