// SPDX-License-Identifier: BSD-3-Clause
// The scenes with other range sensors from end to end: rays reach the runtime, the log holds them, and a
// replay comes to the same.
#include <catch2/catch.hpp>

#include "drivers/wire_ssl.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {
namespace {

firmware::LiveRunOutcome run_sensors(const std::string& scene, const std::string& log,
                                     std::vector<std::string> overrides = {}) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = std::move(overrides);
  options.seconds = 1.5;
  options.virtual_time = true;
  options.record = log;
  options.record_fields = true;
  options.lcm_url = "none";
  return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
}

std::uint64_t ran(const firmware::LiveRunOutcome& run, const std::string& name) {
  return run.results.counters.at(name);
}

}  // namespace

TEST_CASE("a rolling laser that sees the robot runs, and its log replays to the same digest") {
  const TempFolder folder;
  const std::string log = folder.file("laser.lcm");
  const firmware::LiveRunOutcome run = run_sensors("ugv_laser", log);
  CHECK(ran(run, "scans") == 14);
  CHECK(ran(run, "points_used") > 5000);
  CHECK(ran(run, "points_in") == ran(run, "points_used") + ran(run, "points_too_near") +
                                     ran(run, "points_too_far") + ran(run, "points_on_robot") +
                                     ran(run, "points_outside") + ran(run, "points_unplaced"));
  CHECK(ran(run, "points_on_robot") > 500);
  CHECK(ran(run, "bench_lidar_own") > 500);
  CHECK(ran(run, "bench_lidar_mixed") > 100);
  CHECK(ran(run, "bench_lidar_weak") > 100);
  CHECK(ran(run, "bench_lidar_refused") == 0);
  if (rt::posix::kHeapTrapAvailable) CHECK(ran(run, "heap_calls") == 0);
  const firmware::ReplayOutcome again = replay_log(log);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  // The same run twice, and one without the robot in the picture.
  CHECK(run_sensors("ugv_laser", folder.file("twice.lcm")).results.digest == run.results.digest);
  const auto without = run_sensors("ugv_laser", folder.file("without.lcm"), {"hil.self_hits=false"});
  CHECK(ran(without, "bench_lidar_own") == 0);
  CHECK(without.results.digest != run.results.digest);
}

TEST_CASE(
    "a solid-state lidar is asked, answers, and both stand in the log that replays to the same digest") {
  const TempFolder folder;
  const std::string log = folder.file("ssl.lcm");
  const firmware::LiveRunOutcome run = run_sensors("ugv_ssl", log, {"hil.lidar_columns=64"});
  CHECK(ran(run, "ssl_commands_sent") == 14);
  CHECK(ran(run, "ssl_commands_refused") == 0);
  CHECK(ran(run, "bench_ssl_rays") == 14 * 200);
  CHECK(ran(run, "bench_ssl_returned") > 1000);
  CHECK(ran(run, "scans") == 14);
  if (rt::posix::kHeapTrapAvailable) CHECK(ran(run, "heap_calls") == 0);
  const firmware::ReplayOutcome again = replay_log(log);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);

  // Every answer is that of the command with its number, ray by ray, one frame of 20 ms after it was sent.
  drivers::LcmLogReader reader(log);
  drivers::LogEvent event;
  std::vector<rt::SslCommand> commands;
  std::vector<std::int64_t> sent_us;
  std::uint32_t answers = 0;
  std::int64_t seq = 0;
  while (reader.next(event) == Status::ok) {
    if (event.channel == drivers::kChannelSslCommand) {
      commands.emplace_back();
      REQUIRE(drivers::decode(event.data, commands.back(), seq) == Status::ok);
      sent_us.push_back(event.timestamp_us);
    } else if (event.channel == drivers::kChannelSsl) {
      rt::SslReturns returns;
      REQUIRE(drivers::decode(event.data, returns, seq) == Status::ok);
      REQUIRE(seq == static_cast<std::int64_t>(answers));
      REQUIRE(answers < commands.size());
      const rt::SslCommand& asked = commands[answers];
      REQUIRE(returns.number == asked.number);
      REQUIRE(returns.rays == asked.rays);
      for (std::uint32_t i = 0; i < returns.rays; ++i) REQUIRE(returns.direction[i] == asked.direction[i]);
      CHECK(returns.stamp_ns / 1000 - sent_us[answers] == 20'000);
      ++answers;
    }
  }
  CHECK(commands.size() == 14);
  CHECK(answers == 14);
}

TEST_CASE("a log with a solid-state lidar that loses frames goes on from a keyframe as from its start") {
  const TempFolder folder;
  const std::string log = folder.file("ssl.lcm");
  const auto run = run_sensors("ugv_ssl", log, {"hil.lidar_columns=16", "hil.ssl.drop=0.3"});
  CHECK(ran(run, "bench_ssl_rays") == 14 * 200);
  const Indexed full = replay_and_keep(log, firmware::own_vehicles(), {}, 250, firmware::keyframe_path(log));
  CHECK(complaint_of(full.outcome).empty());
  firmware::ReplayOptions options;
  options.from = "@800";
  const firmware::ReplayOutcome part = replay_log(log, options);
  CHECK(part.restored_tick == 750);
  CHECK_FALSE(part.divergence);
  CHECK(part.results.digest == run.results.digest);
}

TEST_CASE("settings of range sensors that cannot be are errors that name them") {
  const auto complaint = [](std::vector<std::string> overrides) {
    return message_of<std::runtime_error>([&] {
      firmware::LiveRunOptions options;
      options.scene = "ugv_laser";
      options.overrides = std::move(overrides);
      options.seconds = 0.1;
      options.virtual_time = true;
      options.lcm_url = "none";
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
    });
  };
  CHECK(mentions(complaint({"hil.lidar.kind=\"radar\""}), "hil.lidar.kind"));
  CHECK(mentions(complaint({"hil.lidar.kind=\"rows_64\"", "hil.lidar_rows=32"}), "hil.lidar_rows"));
  CHECK(mentions(complaint({"hil.lidar.beams=1"}), "hil.lidar.beams"));
  CHECK(mentions(complaint({"hil.lidar.lines_per_scan=50"}), "lines_per_scan"));
  CHECK(mentions(complaint({"hil.lidar.graze_deg=91"}), "hil.lidar.graze_deg"));
  CHECK(mentions(complaint({"hil.ssl.max_range_m=70"}), "hil.ssl.max_range_m"));
}

}  // namespace sortie::testing
