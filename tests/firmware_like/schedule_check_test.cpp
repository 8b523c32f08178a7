// SPDX-License-Identifier: BSD-3-Clause
// Scenes whose tables or chains cannot keep what they promise are refused with the figures and the cures;
// those that can show both, computed and measured.
#include "firmware_like/runtime/schedule_check.hpp"
#include "firmware_like/scene/json.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "firmware_like/scene/json.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

std::string hall_error(const std::vector<std::string>& overrides) {
  return message_of<ProfileError>(
      [&] { const Runtime runtime(load_scene("ugv_hall", overrides), own_vehicles(), RuntimeStart{}); });
}

Results loaded(const std::vector<std::string>& overrides) {
  const Runtime runtime(load_scene("ugv_hall", overrides), own_vehicles(), RuntimeStart{});
  return collect_results(runtime, 0);
}

// Worst response of the slower group of the hall [us]: its work in what the faster one leaves of each tick.
double mapping_response(const ScheduleResult& schedule) {
  REQUIRE(schedule.groups.size() == 2);
  const double control = schedule.groups[0].budget_us;
  const double ticks = std::floor(schedule.groups[1].budget_us / (1000 - control));
  return ticks * 1000 + control + schedule.groups[1].budget_us - ticks * (1000 - control);
}

const ChainResult& chain_named(const Results& results, const std::string& name) {
  for (const ChainResult& chain : results.chains) {
    if (chain.name == name) return chain;
  }
  FAIL("no chain " << name);
  return results.chains.front();
}

}  // namespace

TEST_CASE("a group that can be late by its budgets is refused with response and deadline and cures") {
  const std::string late = hall_error({"tasks.map.budget_us=90000"});
  INFO(late);
  CHECK(mentions(late, "groups.mapping.rate_hz"));
  CHECK(mentions(late, "group mapping can be done"));
  CHECK(mentions(late, "its deadline is 100 ms"));
  CHECK(mentions(late, "more than all of it"));
  CHECK(mentions(late, "tasks.map.budget_us"));
  CHECK(mentions(late, "groups.mapping.core"));
  CHECK(mentions(late, "schedule.accept_overload = true"));

  // A deadline alone can be too early: 50 ms of work are done after some 59 ms.
  const int in_time = static_cast<int>(std::ceil(mapping_response(loaded({}).schedule) / 1000));
  const std::string early = hall_error({"groups.mapping.deadline_ticks=" + std::to_string(in_time - 1)});
  INFO(early);
  CHECK(mentions(early, "after its release, but its deadline is " + std::to_string(in_time - 1) + " ms"));
  CHECK_FALSE(mentions(early, "more than all of it"));
  CHECK(hall_error({"groups.mapping.deadline_ticks=" + std::to_string(in_time)}).empty());
}

TEST_CASE("overload that is accepted runs and is warned about, so is a processor that is nearly full") {
  const Results over = loaded({"tasks.map.budget_us=90000", "schedule.accept_overload=true"});
  CHECK_FALSE(over.schedule.schedulable);
  REQUIRE(over.warnings.size() >= 2);
  CHECK(over.schedule.cores[0].utilisation[0] > 1.04);
  CHECK(mentions(over.warnings[0], "% of its time by control, mapping, more than all of it"));
  CHECK(mentions(over.warnings[1], "group mapping can be done ever later"));

  const Results full = loaded({"tasks.map.budget_us=80000"});
  CHECK(full.schedule.schedulable);
  REQUIRE(full.warnings.size() == 1);
  CHECK(full.schedule.cores[0].utilisation[0] == Approx(0.955).margin(0.01));
  CHECK(mentions(full.warnings[0], "schedule: a processor is asked for 9"));
  CHECK(loaded({}).warnings.empty());
}

TEST_CASE("another core takes the load off") {
  // 15 % here and 90 % there, not 105 % of one.
  const Results apart =
      loaded({"tasks.map.budget_us=90000", "groups.control.core=0", "groups.mapping.core=1"});
  CHECK(apart.schedule.schedulable);
  REQUIRE(apart.schedule.cores.size() == 2);
  CHECK(apart.schedule.cores[1].utilisation[0] == Approx(0.9).margin(0.01));
  REQUIRE(apart.schedule.groups.size() == 2);
  CHECK(apart.schedule.groups[1].response_us == Approx(apart.schedule.groups[1].budget_us));
}

TEST_CASE("the table of a scene shows figures that can be checked by hand") {
  const ScheduleResult schedule = loaded({}).schedule;
  CHECK(schedule.hyperperiod_ticks == 100);
  CHECK(schedule.harmonic);
  CHECK(schedule.schedulable);
  REQUIRE(schedule.groups.size() == 2);
  CHECK(schedule.groups[0].name == "control");
  CHECK(schedule.groups[0].priority == 0);
  const double control = schedule.groups[0].budget_us;
  const double mapping = schedule.groups[1].budget_us;
  CHECK(control >= 150);
  CHECK(mapping >= 50'000);
  CHECK(schedule.groups[0].response_us == Approx(control));
  CHECK(schedule.groups[1].response_us == Approx(mapping_response(schedule)));
  REQUIRE(schedule.cores.size() == 1);
  CHECK(schedule.cores[0].utilisation[0] == Approx(control / 1000 + mapping / 100'000));
  CHECK(schedule.cores[0].worst_tick_us == Approx(control + mapping));
  std::ostringstream text;
  print_schedule(text, schedule);
  INFO(text.str());
  CHECK(mentions(text.str(), "hyperperiod 100 ticks of 1000 us, harmonic, schedulable"));
  CHECK(mentions(text.str(), "worst tick"));
}

TEST_CASE("a chain beyond its bound is refused with both numbers") {
  CHECK(hall_error({"chains.imu_to_drive.max_reaction_ms=2"}).empty());
  const std::string slow = hall_error({"chains.imu_to_drive.max_reaction_ms=1.9"});
  INFO(slow);
  CHECK(mentions(
      slow,
      "chains.imu_to_drive.max_reaction_ms: the worst reaction time is 2 ms, above the allowed 1.90 ms"));
  CHECK(mentions(slow, "control"));
  const std::string old =
      hall_error({"chains.scan_to_map.max_age_ms=199", "chains.scan_to_map.source_interval_ms=100"});
  INFO(old);
  CHECK(mentions(old, "the worst data age is 200 ms, above the allowed 199 ms"));
}

TEST_CASE("a path that the table does not have is refused with what there is instead") {
  const std::string unknown = hall_error({"chains.mine.path=[\"IMU\", \"altitude\"]"});
  INFO(unknown);
  CHECK(mentions(unknown, "chains.mine.path: \"altitude\" is no task of this scene"));
  CHECK(mentions(unknown, "attitude"));
  const std::string stream = hall_error({"chains.mine.path=[\"IMUU\", \"attitude\"]"});
  CHECK(mentions(stream, "\"IMUU\" is no stream or task"));
  for (const char* name : {"IMU", "TRACK", "SCAN", "odometry"}) CHECK(mentions(stream, name));
  const std::string elsewhere = hall_error({"chains.mine.path=[\"SCAN\", \"attitude\"]"});
  INFO(elsewhere);
  CHECK(mentions(elsewhere, "group control of task attitude does not consume SCAN; it consumes: IMU"));
  const std::string hop = hall_error({"chains.mine.path=[\"IMU\", \"attitude\", \"map\"]"});
  INFO(hop);
  CHECK(mentions(hop, "group mapping of task map has no input from attitude; it reads: odometry"));
  CHECK(mentions(hall_error({"chains.mine.max_age_ms=3"}), "needs a path"));
  CHECK(mentions(hall_error({"chains.mine.path=[\"IMU\"]"}), "names a stream and no task"));
  CHECK(mentions(hall_error({"chains.mine.path=[1, 2]"}), "text in quotes"));
  CHECK(mentions(hall_error({"chains.mine.path=\"IMU\""}), "list of texts"));
  CHECK(mentions(hall_error({"chains.mine.path=[\"IMU\", \"attitude\"]", "chains.mine.max_age=3"}),
                 "unknown key"));
  CHECK(hall_error({"chains.mine.path=[\"IMU\", \"attitude\", \"odometry\", \"map\"]"}).empty());
}

TEST_CASE("a stream that comes faster than its batches is warned about") {
  const Results fast = loaded({"chains.scan_to_map.source_interval_ms=10"});
  REQUIRE(fast.warnings.size() == 1);
  CHECK(mentions(fast.warnings[0],
                 "chain scan_to_map: 10 samples of SCAN come for each release of group mapping"));
}

TEST_CASE("a virtual run measures every chain, within its bounds, and a replay measures the same") {
  const TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  const LiveRunOutcome run = run_hall(4, log);
  const ReplayOutcome again = replay_log(log);
  REQUIRE(run.results.chains.size() == 2);
  for (const ChainResult& chain : run.results.chains) {
    INFO(chain.name);
    CHECK(chain.exact);
    CHECK(chain.unmeasured == 0);
    CHECK(chain.reaction.count > 30);
    CHECK(chain.reaction.max_us <= chain.reaction_us);
    // The age that was computed is for a sample at every release; these come less often.
    CHECK(chain.age.max_us <= chain.age_us + chain.source_interval_max_us);
    CHECK(chain.finished.count == 0);
    const ChainResult& replayed = chain_named(again.results, chain.name);
    CHECK(replayed.reaction.count == chain.reaction.count);
    CHECK(replayed.reaction.max_us == Approx(chain.reaction.max_us).margin(1));
    CHECK(replayed.age.count == chain.age.count);
  }
  // One entry for each sample that the filter used: nothing is counted twice or forgotten.
  const ChainResult& imu = chain_named(run.results, "imu_to_drive");
  CHECK(imu.reaction.count == run.results.counters.at("imu_used"));
}

TEST_CASE("a live run measures its chains on the real clock, through missed jobs too") {
  const TempFolder folder;
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.overrides = {"chains.hop.path=[\"SORTIE_CUSTOM_fast\", \"quick\", \"heavy\"]"};
  options.seconds = 1;
  options.realtime = false;
  options.lcm_url = "none";
  stalls = {1500, 0, 0};
  const LiveRunOutcome run = run_live_undisturbed(stall_vehicles(), nullptr, options);
  stalls = {};
  const ChainResult& chain = chain_named(run.results, "hop");
  CHECK(chain.reaction.count > 20);
  CHECK(chain.finished.count == chain.reaction.count);
  CHECK(chain.finished.max_us > 0);
  // 1 ms to be taken, 1 ms to be visible, up to 19 ms to be read, 20 ms to the deadline.
  CHECK(chain.reaction_us == Approx(41'000));
}
