// SPDX-License-Identifier: BSD-3-Clause
// A log replays to what it was recorded from, bit for bit; a fault is located, and what cannot be compared is
// not.
#include "firmware_like/log/replay.hpp"

#include <catch2/catch.hpp>

#include "drivers/channels.hpp"
#include "drivers/wire_records.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

TEST_CASE("a recorded run replays to the same digest, task by task, on one thread and on many") {
  REQUIRE(two_seconds().run.results.counters.at("jobs") > 2000);
  for (const bool threaded : {false, true}) {
    INFO((threaded ? "threaded" : "one thread"));
    ReplayOptions options;
    options.threaded = threaded;
    const ReplayOutcome outcome = replay_log(two_seconds().log, options);
    CHECK(complaint_of(outcome) == "");
    CHECK(outcome.results.digest == two_seconds().run.results.digest);
    CHECK(outcome.results.ticks == two_seconds().run.results.ticks);
    REQUIRE(outcome.results.tasks.size() == two_seconds().run.results.tasks.size());
    for (std::size_t i = 0; i < outcome.results.tasks.size(); ++i) {
      INFO(outcome.results.tasks[i].name);
      CHECK(outcome.results.tasks[i].digest == two_seconds().run.results.tasks[i].digest);
      CHECK(outcome.results.tasks[i].count == two_seconds().run.results.tasks[i].count);
    }
    // The same errors, too: poses and truth come out of the log as they went in.
    CHECK(errors_of(outcome) == errors_of(two_seconds().run));
  }
}

TEST_CASE("neither a virtual run nor its replay takes heap in a task") {
  if (!watch_heap()) {
    WARN("skipped: no heap trap under this sanitizer or C library");
    return;
  }
  const TempFolder folder;
  const LiveRunOutcome run = run_hall(1, folder.file("heap.lcm"));
  CHECK(run.results.counters.at("heap_calls") == 0);
  CHECK(counter(replay_log(folder.file("heap.lcm")), "heap_calls") == 0);
  firmware::set_heap_watch({});
}

TEST_CASE("a bit flipped in any task is located to its tick, task and field") {
  const Runtime& runtime = *two_seconds().run.runtime;
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i) {
    const rt::TaskBase& task = executive.task(i);
    const rt::GroupTiming timing = executive.group(task.group()).timing;
    const rt::Tick tick = timing.release(timing.job_at(1200));
    for (const bool threaded : {false, true}) {
      INFO(task.name() << "@" << tick << (threaded ? " threaded" : ""));
      ReplayOptions options;
      options.threaded = threaded;
      options.fault = std::string(task.name()) + "@" + std::to_string(tick);
      const ReplayOutcome outcome = replay_log(two_seconds().log, options);
      REQUIRE(outcome.divergence.has_value());
      CHECK(outcome.divergence->tick == tick);
      CHECK(outcome.divergence->task == task.name());
      CHECK(outcome.divergence->group == executive.group(task.group()).spec.name);
      CHECK_FALSE(outcome.divergence->field.empty());
      CHECK(outcome.divergence->was != outcome.divergence->is);
      CHECK(outcome.results.digest != two_seconds().run.results.digest);
    }
  }
  // The first byte of an odometry output is the stamp's.
  ReplayOptions options;
  options.fault = "odometry.8@1200";
  const ReplayOutcome outcome = replay_log(two_seconds().log, options);
  REQUIRE(outcome.divergence.has_value());
  CHECK(outcome.divergence->field == "p_world_body_m[0]");
  CHECK(describe(*outcome.divergence).find("tick 1200, task odometry") != std::string::npos);
  CHECK(complaint_of(outcome) == describe(*outcome.divergence));
}

TEST_CASE("a fault that names no task or no tick is refused") {
  for (const char* fault : {"odometry", "nobody@3", "odometry@", "odometry.x@3", "@3", "odometry@-1",
                            "odometry@12x", "odometry.8x@1200"}) {
    INFO(fault);
    ReplayOptions options;
    options.fault = fault;
    const std::string why =
        message_of<ProfileError>([&] { static_cast<void>(replay_log(two_seconds().log, options)); });
    CHECK(why.find("task@tick") != std::string::npos);
  }
  ReplayOptions options;
  const auto replay = [&] { static_cast<void>(replay_log(two_seconds().log, options)); };
  options.fault = "odometry@99999999";
  CHECK(message_of<InputError>(replay).find("no job at that tick") != std::string::npos);
  options.fault = "odometry.99999@1200";
  CHECK(message_of<ProfileError>(replay).find("bytes, 0 is the first") != std::string::npos);
}

TEST_CASE("a log of another version replays, but its digests are not compared") {
  const TempFolder folder;
  const std::string path = folder.file("older.lcm");
  rewrite_log(two_seconds().log, path, [](EditableEvent& event, std::size_t) {
    if (event.channel == drivers::kChannelHeader) {
      drivers::LogHeader header;
      REQUIRE(drivers::decode(event.bytes, header) == Status::ok);
      header.version = "0.0.9";
      event.bytes.resize(drivers::encoded_bytes(header));
      std::size_t size = 0;
      REQUIRE(drivers::encode(header, event.bytes, size) == Status::ok);
      event.bytes.resize(size);
    }
    return true;
  });
  const ReplayOutcome outcome = replay_log(path);
  CHECK_FALSE(outcome.comparable);
  CHECK(outcome.why_not_comparable.find("0.0.9") != std::string::npos);
  CHECK(outcome.results.digest == two_seconds().run.results.digest);  // the code is still the same
}

TEST_CASE("another scene or other parameters replay the samples and are not compared") {
  ReplayOptions other;
  other.overrides = {"map.voxel_m=0.2"};
  const ReplayOutcome coarse = replay_log(two_seconds().log, other);
  CHECK_FALSE(coarse.comparable);
  CHECK(mentions(coarse.results.warnings, "not comparable"));
  CHECK(complaint_of(coarse) != "");
  CHECK(coarse.results.digest != two_seconds().run.results.digest);
  const auto voxels = [](const Results& results) {
    for (const PoolResult& pool : results.pools) {
      if (pool.name == "voxels") return pool.high_water;
    }
    return std::uint64_t{0};
  };
  CHECK(voxels(coarse.results) > 0);
  CHECK(voxels(coarse.results) < voxels(two_seconds().run.results));

  ReplayOptions slower;
  slower.overrides = {"groups.control.rate_hz=100"};
  const ReplayOutcome slow = replay_log(two_seconds().log, slower);
  CHECK_FALSE(slow.comparable);
  CHECK(counter(slow, "imu_used") == two_seconds().run.results.counters.at("imu_used"));

  ReplayOptions scene;
  scene.scene = "skid_outdoor";
  const ReplayOutcome outdoor = replay_log(two_seconds().log, scene);
  CHECK_FALSE(outdoor.comparable);
  CHECK(mentions(outdoor.results.warnings, "SCAN"));
}

TEST_CASE("samples that a log has lost without a word are counted when its jobs ask for them") {
  const TempFolder folder;
  const std::string thin = folder.file("thin.lcm");
  std::uint64_t dropped = 0;
  rewrite_log(two_seconds().log, thin, [&dropped](EditableEvent& event, std::size_t index) {
    const bool drops = event.channel == drivers::kChannelImu && index % 40 == 13;
    dropped += drops ? 1 : 0;
    return !drops;
  });
  REQUIRE(dropped == 10);
  CHECK(counter(replay_log(thin), "samples_missing") == dropped);
  CHECK(counter(replay_log(two_seconds().log), "samples_missing") == 0);
}

TEST_CASE("what a replay writes is a log that replays to the same digest") {
  const TempFolder folder;
  ReplayOptions options;
  options.overrides = {"map.voxel_m=0.2"};
  options.record = folder.file("what_if.lcm");
  const ReplayOutcome first = replay_log(two_seconds().log, options);
  const ReplayOutcome again = replay_log(options.record);
  CHECK(complaint_of(again) == "");
  CHECK(again.results.digest == first.results.digest);
  CHECK(errors_of(again) == errors_of(first));
}
