// SPDX-License-Identifier: BSD-3-Clause
// Live runs whose jobs stall longer than their slack: what is missed, skipped and refused then depends on the
// machine's mood, and the log's replay must give the same digest every time.
#include "firmware_like/live/live_run.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/stall_vehicle.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

LiveRunOptions live_options(const TempFolder& folder, double seconds) {
  LiveRunOptions options;
  options.scene = stall_scene(folder);
  options.seconds = seconds;
  options.realtime = false;  // the machine's mood is wanted here
  options.record = folder.file("live.lcm");
  options.record_fields = true;
  options.lcm_url = "none";
  return options;
}

// A live run that ends when its tasks have done what the test is about, however long the machine takes for
// it; after two minutes in any case.
template <class Enough>
LiveRunOutcome run_until(LiveRunOptions options, Enough enough) {
  std::atomic<bool> ended{false};
  stall_counts.jobs = 0;
  stall_counts.fast_stalled = 0;
  stall_counts.slow_stalled = 0;
  options.seconds = 120;
  options.progress = [&](double) { ended.store(enough(stall_counts)); };
  options.interrupted = &ended;
  LiveRunOutcome run = run_live(stall_vehicles(), nullptr, options);
  REQUIRE(ended.load());
  CHECK(run.results.counters.at("jobs") == stall_counts.jobs.load());
  return run;
}

// Replays on one thread and on many, with other delays than in the live run.
void check_replays(const std::string& log_path, const LiveRunOutcome& run) {
  const LogFile log(log_path);
  CHECK(log.problems().empty());
  for (const bool threaded : {false, true}) {
    INFO((threaded ? "threaded" : "one thread"));
    stalls = threaded ? Stalls{300, 700, 0} : Stalls{};
    ReplayOptions options;
    options.threaded = threaded;
    const ReplayOutcome outcome = replay(log, stall_vehicles(), options);
    if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
    CHECK(outcome.comparable);
    CHECK(outcome.results.digest == run.results.digest);
    CHECK(hex(outcome.recorded.all) == run.results.digest);
    CHECK(outcome.recorded.jobs == run.results.counters.at("jobs"));
    CHECK(outcome.results.counters.at("missed_jobs") == run.results.counters.at("missed_jobs"));
    // As far as the run came, and what it left out on the way, also before its first job and after its last.
    CHECK(outcome.results.ticks == run.results.ticks);
    CHECK(outcome.results.duration_s == Approx(run.results.duration_s));
    CHECK(outcome.results.counters.at("skipped_releases") == run.results.counters.at("skipped_releases"));
    for (std::size_t i = 0; i < run.results.groups.size(); ++i)
      CHECK(outcome.results.groups[i].skipped == run.results.groups[i].skipped);
    CHECK(outcome.results.counters.at("samples_missing") == 0);
    CHECK(outcome.results.counters.at("samples_refused") == 0);
  }
}

}  // namespace

TEST_CASE("a live run with stalls longer than the slack replays to its digest, without heap") {
  const bool counts_heap = watch_heap();
  const TempFolder folder;
  stalls = {3'500, 30'000, 100};
  const LiveRunOptions options = live_options(folder, 0);
  const LiveRunOutcome run = run_until(options, [](const StallCounts& counts) {
    return counts.fast_stalled >= 20 && counts.slow_stalled >= 5;
  });
  const auto& counters = run.results.counters;
  // Whoever stalls is late; a fast job leaves out the two releases that its own stall covers, too, but for
  // the run's last. Above that the machine adds its own.
  CHECK(counters.at("missed_jobs") >= stall_counts.fast_stalled + stall_counts.slow_stalled);
  CHECK(counters.at("skipped_releases") >= 2 * (stall_counts.fast_stalled - 1));
  CHECK(counters.at("refused_samples") > 0);
  REQUIRE(counters.at("log_lost_jobs") == 0);
  REQUIRE(counters.at("log_lost_samples") == 0);
  if (counts_heap) CHECK(counters.at("heap_calls") == 0);
  for (const TaskResult& task : run.results.tasks) {
    INFO(task.name);
    CHECK(task.missed > 0);
    CHECK(task.max_us > (task.name == "quick" ? 3'000 : 29'000));
  }
  check_replays(options.record, run);
  set_heap_watch({});
}

TEST_CASE("a live run that is interrupted leaves a log that replays whole") {
  const TempFolder folder;
  stalls = {0, 25'000, 0};
  const LiveRunOptions options = live_options(folder, 0);
  const LiveRunOutcome run = run_until(
      options, [](const StallCounts& counts) { return counts.jobs > 50 && counts.slow_stalled > 0; });
  CHECK(run.results.ticks < 120'000);
  CHECK(run.results.duration_s == Approx(static_cast<double>(run.results.ticks) * 1e-3));
  for (const GroupResult& group : run.results.groups) {
    // Each release of the run was run or left out, and none behind its end.
    const double period = group.period_us * 1e-3;
    CHECK(static_cast<double>(group.jobs + group.skipped) * period + group.phase_us * 1e-3 <
          static_cast<double>(run.results.ticks) + period);
    CHECK(static_cast<double>(group.jobs + group.skipped) * period + group.phase_us * 1e-3 >=
          static_cast<double>(run.results.ticks));
  }
  check_replays(options.record, run);
}

TEST_CASE("a live run without misses is replayed, too, and a virtual run needs a robot") {
  const TempFolder folder;
  stalls = {};
  LiveRunOptions options = live_options(folder, 0);
  const LiveRunOutcome run = run_until(options, [](const StallCounts& counts) { return counts.jobs > 200; });
  check_replays(options.record, run);
  options.virtual_time = true;
  CHECK(message_of<ProfileError>([&] {
          run_live(stall_vehicles(), nullptr, options);
        }).find("simulated robot") != std::string::npos);
}

TEST_CASE(
    "a live run of the simulated hall, plant and devices on threads of their own, replays to its digest") {
  const TempFolder folder;
  LiveRunOptions options = live_options(folder, 1);
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=4", "hil.lidar_columns=64", "limits.voxels=32768"};
  // A busy machine may take several seconds to its first scan.
  LiveRunOutcome run = run_live(own_vehicles(), make_simulated_robot, options);
  for (; run.results.counters.at("scans") == 0 && options.seconds < 32; options.seconds *= 2)
    run = run_live(own_vehicles(), make_simulated_robot, options);
  CHECK(run.results.counters.at("imu_used") > 0);
  CHECK(run.results.counters.at("scans") > 0);
  const LogFile log(options.record);
  for (const bool threaded : {false, true}) {
    ReplayOptions replaying;
    replaying.threaded = threaded;
    const ReplayOutcome outcome = replay(log, own_vehicles(), replaying);
    if (outcome.divergence) FAIL_CHECK(describe(*outcome.divergence));
    CHECK(outcome.results.digest == run.results.digest);
    CHECK(outcome.results.counters.at("samples_missing") == 0);
  }
}

TEST_CASE("a run shorter than a tick still ends, after one") {
  LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = {"hil.lidar_rows=2", "hil.lidar_columns=16"};
  options.seconds = 1e-5;
  options.virtual_time = true;
  options.lcm_url = "none";
  CHECK(run_live(own_vehicles(), make_simulated_robot, options).results.ticks == 1);
}
