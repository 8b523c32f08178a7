// SPDX-License-Identifier: BSD-3-Clause
// Declared bounds of chains: what cannot be computed is refused, and what is measured above is never silent:
// a failure in simulated time, a counted event in a live run.
#include <catch2/catch.hpp>

#include "drivers/wire_records.hpp"
#include "firmware_like/log/log_file.hpp"
#include "firmware_like/runtime/chain_watch.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// The inertial sensor sends every 5 ms; a promise of 1 ms makes the table believe in a younger output.
const std::vector<std::string> kBrokenPromise{"chains.mine.path=[\"IMU\", \"attitude\"]",
                                              "chains.mine.source_interval_ms=1", "chains.mine.max_age_ms=4"};

LiveRunOptions options_of(std::vector<std::string> overrides, double seconds, bool virtual_time) {
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768"};
  options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
  options.seconds = seconds;
  options.virtual_time = virtual_time;
  options.lcm_url = "none";
  return options;
}

LiveRunOutcome run(const LiveRunOptions& options) {
  return run_live(own_vehicles(), make_simulated_robot, options);
}

}  // namespace

TEST_CASE("a bound on age that nothing can be computed from is refused with what is missing") {
  const std::string refusal = message_of<ProfileError>([] {
    run(options_of({"chains.mine.path=[\"IMU\", \"attitude\"]", "chains.mine.max_age_ms=6"}, 0.1, true));
  });
  INFO(refusal);
  CHECK(mentions(refusal, "chains.mine.max_age_ms: the age of what comes from IMU cannot be bounded"));
  CHECK(mentions(refusal, "chains.mine.source_interval_ms is missing"));
  // A chain that begins with a task has a value at every release.
  CHECK_NOTHROW(run(
      options_of({"chains.mine.path=[\"attitude\", \"odometry\"]", "chains.mine.max_age_ms=6"}, 0.1, true)));
}

TEST_CASE("in simulated time what is measured above its bound fails the run, and the check of its log") {
  const TempFolder folder;
  LiveRunOptions options = options_of(kBrokenPromise, 1, true);
  options.record = folder.file("hall.lcm");
  const LiveRunOutcome outcome = run(options);
  REQUIRE(outcome.failures.size() == 1);
  INFO(outcome.failures[0]);
  CHECK(mentions(outcome.failures[0], "chain mine: data age up to "));
  CHECK(mentions(outcome.failures[0], "max_age_ms allows 4 ms"));
  CHECK(mentions(outcome.results.warnings, outcome.failures[0]));
  CHECK(outcome.results.counters.at("chain_bounds_exceeded") > 100);
  const ReplayOutcome again = replay_log(options.record);
  CHECK(again.failures == outcome.failures);
  CHECK(counter(again, "chain_bounds_exceeded") == outcome.results.counters.at("chain_bounds_exceeded"));
  const LiveRunOutcome kept = run(options_of({}, 1, true));
  CHECK(kept.failures.empty());
  CHECK(kept.results.counters.at("chain_bounds_exceeded") == 0);
}

TEST_CASE("a live run counts what is above its bound, tells it as it happens, and goes on") {
  const TempFolder folder;
  LiveRunOptions options = options_of(kBrokenPromise, 1, false);
  options.realtime = false;
  options.record = folder.file("hall.lcm");
  const LiveRunOutcome outcome = run(options);
  CHECK(outcome.failures.empty());
  CHECK(outcome.results.counters.at("chain_bounds_exceeded") > 0);
  CHECK(mentions(outcome.results.warnings, "chain mine: data age up to "));
  const LogFile log(options.record);
  int told = 0;
  for (const StoredEvent& stored : log.channel(std::string(drivers::kChannelEvent))) {
    drivers::EventRecord event;
    REQUIRE(drivers::decode(stored.message, event) == Status::ok);
    // A busy machine may break the bounds of other chains as well.
    if (event.kind != "chain" || event.subject != "mine") continue;
    ++told;
    CHECK(mentions(event.text, "max_age_ms allows 4 ms"));
  }
  CHECK(told >= 1);
  CHECK(told <= 3);  // once a second
  CHECK(replay(log, own_vehicles(), {}).failures.empty());
}
