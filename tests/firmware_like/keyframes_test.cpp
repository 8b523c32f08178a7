// SPDX-License-Identifier: BSD-3-Clause
// A replay that begins at a keyframe goes on as if it had begun at the start.
#include "firmware_like/log/keyframes.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// What must not depend on where the replay began: everything but what was measured.
void check_same_end(const ReplayOutcome& full, const ReplayOutcome& part) {
  if (part.divergence) FAIL_CHECK(describe(*part.divergence));
  CHECK(part.results.digest == full.results.digest);
  REQUIRE(part.results.tasks.size() == full.results.tasks.size());
  for (std::size_t i = 0; i < full.results.tasks.size(); ++i) {
    INFO(full.results.tasks[i].name);
    CHECK(part.results.tasks[i].digest == full.results.tasks[i].digest);
  }
  for (const auto& [name, value] : full.results.counters) {
    if (name == "over_budget" || name == "heap_calls") continue;
    INFO(name);
    CHECK(part.results.counters.at(name) == value);
  }
  CHECK(part.failures.empty());
  for (const ChainResult& chain : part.results.chains) {  // measured from where it began, by the same numbers
    INFO(chain.name);
    CHECK(chain.reaction.max_us <= chain.reaction_us);
    CHECK(chain.age.max_us <= chain.age_us);
  }
  REQUIRE(part.results.pools.size() == full.results.pools.size());
  for (std::size_t i = 0; i < full.results.pools.size(); ++i) {
    INFO(full.results.pools[i].name);
    CHECK(part.results.pools[i].high_water == full.results.pools[i].high_water);
    CHECK(part.results.pools[i].refused == full.results.pools[i].refused);
  }
}

}  // namespace

TEST_CASE("a replay from any keyframe ends in the same state as the whole one") {
  REQUIRE(hall().full.states.size() > 70);
  const std::uint32_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 12; ++round) {
    ReplayOptions options;
    const rt::Tick from = 25 + random() % 1950;
    options.from = "@" + std::to_string(from);
    options.threaded = round == 11;
    INFO("from tick " << from);
    if (options.threaded) {
      const ReplayOutcome part = replay_log(hall().log, options);
      CHECK(part.restored_tick == from / 25 * 25);
      check_same_end(hall().full.outcome, part);
      continue;
    }
    const Indexed part = replay_and_keep(hall().log, own_vehicles(), options, 25);
    CHECK(part.outcome.restored_tick == from / 25 * 25);
    CHECK(part.outcome.first_tick == from);
    check_same_end(hall().full.outcome, part.outcome);
    // Byte by byte the same state at every keyframe on the way, the first one included.
    REQUIRE(part.states.begin()->first == part.outcome.restored_tick);
    for (const auto& [tick, state] : part.states) {
      INFO("state at tick " << tick);
      CHECK((state == hall().full.states.at(tick)));  // too long to print
    }
  }
}

TEST_CASE("a part of a log is compared with that part of what was recorded") {
  ReplayOptions options;
  options.from = "0.5";
  options.to = "1.25";
  const ReplayOutcome part = replay_log(hall().log, options);
  CHECK(part.comparable);
  CHECK_FALSE(part.divergence.has_value());
  CHECK(part.first_tick == 500);
  CHECK(part.results.ticks == 750);
  CHECK(hex(part.recorded.all) == part.results.digest);
  CHECK(part.results.digest != hall().full.outcome.results.digest);
  CHECK(part.estimate.size() < hall().full.outcome.estimate.size() / 2);
  // Without keyframes the same, only later.
  options.keyframes.clear();
  const TempFolder folder;
  const std::string bare = folder.file("bare.lcm");
  std::filesystem::copy_file(hall().log, bare);
  const ReplayOutcome slow = replay_log(bare, options);
  CHECK(slow.restored_tick == 0);
  CHECK(slow.results.digest == part.results.digest);
  CHECK(slow.estimate.size() == part.estimate.size());
  CHECK(slow.results.ticks == part.results.ticks);

  // A fault inside the part is found, one before it cannot be planted.
  options.fault = "odometry@1000";
  const ReplayOutcome faulty = replay_log(hall().log, options);
  REQUIRE(faulty.divergence.has_value());
  CHECK(faulty.divergence->tick == 1000);
  options.fault = "odometry@100";
  CHECK(mentions(why(options), "before tick 500"));
}

TEST_CASE("jobs that missed their deadlines and other groups' values survive a keyframe") {
  const TempFolder folder;
  const std::string scene = stall_scene(folder);
  const std::string log = folder.file("stall.lcm");
  stalls = {2500, 25000, 40};
  LiveRunOptions live;
  live.scene = scene;
  live.seconds = 1;
  live.record = log;
  live.realtime = false;
  live.lcm_url = "none";
  const LiveRunOutcome run = run_live_undisturbed(stall_vehicles(), nullptr, live);
  stalls = {};
  if (run.results.counters.at("missed_jobs") == 0) {
    WARN("skipped: this machine met every deadline in spite of the stalls");
    return;
  }
  const Indexed full = replay_and_keep(log, stall_vehicles(), {}, 7, keyframe_path(log));
  REQUIRE(full.outcome.comparable);
  REQUIRE_FALSE(full.outcome.divergence.has_value());
  const LogFile file(log);
  for (const auto& [tick, state] : full.states) {
    if (tick % 49 != 0 || tick == 0) continue;
    INFO("from tick " << tick);
    ReplayOptions options;
    options.from = "@" + std::to_string(tick);
    check_same_end(full.outcome, replay(file, stall_vehicles(), options));
  }
}

TEST_CASE("a log without ticks is started at a keyframe of the scene it was indexed with") {
  ReplayOptions options;
  options.scene = "skid_outdoor";
  const TempFolder folder;
  options.keyframes = folder.file("outdoor.keyframes");
  const Indexed full = replay_and_keep(hall().log, own_vehicles(), options, 250, options.keyframes);
  CHECK_FALSE(full.outcome.comparable);
  options.from = "1.1";
  const ReplayOutcome part = replay_log(hall().log, options);
  CHECK(part.restored_tick == 1000);
  check_same_end(full.outcome, part);
  options.scene = "";
  CHECK(mentions(why(options), "another profile"));
}
