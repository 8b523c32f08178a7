// SPDX-License-Identifier: BSD-3-Clause
// Units that the boot of a live run chooses: they fit, the log holds them, and a replay takes those.
#include "firmware_like/live/auto_units.hpp"

#include <catch2/catch.hpp>

#include "drivers/wire_telemetry.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {
namespace {

std::uint32_t ssl_units(const firmware::Runtime& runtime) {
  const rt::Executive& executive = runtime.executive();
  for (std::uint32_t i = 0; i < executive.task_count(); ++i)
    if (std::string(executive.task(i).name()) == "ssl") return executive.task(i).spec().units;
  return 0;
}

firmware::LiveRunOptions live_rays(const std::string& log, std::vector<std::string> overrides) {
  firmware::LiveRunOptions options;
  options.scene = "ugv_ssl";
  options.overrides = {"hil.lidar_columns=16", "occupancy.window_x_m=19.2", "occupancy.window_y_m=19.2"};
  options.overrides.insert(options.overrides.end(), overrides.begin(), overrides.end());
  options.seconds = 1;
  options.realtime = false;
  options.record = log;
  options.lcm_url = "none";
  return options;
}

}  // namespace

TEST_CASE("units = auto become a number at the boot, which the log holds and its replay takes") {
  const TempFolder folder;
  const std::string log = folder.file("auto.lcm");
  const firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot,
                         live_rays(log, {"tasks.ssl.units=auto", "tasks.ssl.budget_us=4000"}));
  const std::uint64_t chosen = run.results.counters.at("calibration_ssl_units");
  const std::uint64_t ps = run.results.counters.at("calibration_ssl_ps_per_unit");
  REQUIRE(ps > 0);
  // 80 % of the budget, in the time that was measured; the counter of it is rounded.
  CHECK(static_cast<double>(chosen * ps) <= 1.001 * 0.8 * 4e9);
  CHECK(static_cast<double>((chosen + 1) * (ps + 1)) >= 0.999 * 0.8 * 4e9);
  CHECK(ssl_units(*run.runtime) == chosen);
  CHECK_FALSE(mentions(run.results.warnings, "calibration"));
  CHECK_FALSE(mentions(run.results.warnings, "auto"));

  const firmware::LogFile file(log);
  CHECK(mentions(file.header().scene_toml, "units = " + std::to_string(chosen)));
  CHECK_FALSE(mentions(file.header().scene_toml, "auto"));
  bool told = false;
  for (const firmware::StoredEvent& stored : file.channel(std::string(drivers::kChannelEvent))) {
    drivers::EventRecord event;
    REQUIRE(drivers::decode(stored.message, event) == Status::ok);
    if (event.kind != "calibration") continue;
    told = true;
    CHECK(event.subject == "ssl");
    CHECK(event.value == static_cast<std::int64_t>(chosen));
  }
  CHECK(told);

  const firmware::ReplayOutcome again = replay_log(log);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  CHECK(ssl_units(*again.runtime) == chosen);
  // The number matters: with another one the outputs differ.
  firmware::ReplayOptions other;
  other.overrides = {"tasks.ssl.units=" + std::to_string(chosen / 100 + 1)};
  CHECK(replay_log(log, other).results.digest != run.results.digest);
}

TEST_CASE("without a clock units = auto are the default, the same each time, and a warning says so") {
  const TempFolder folder;
  const auto simulated = [&](const std::string& name, std::vector<std::string> overrides) {
    firmware::LiveRunOptions options = live_rays(folder.file(name), std::move(overrides));
    options.virtual_time = true;
    return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  };
  const firmware::LiveRunOutcome left = simulated("auto.lcm", {"tasks.ssl.units=\"auto\""});
  CHECK(ssl_units(*left.runtime) == 2'000'000);
  CHECK(left.results.counters.at("calibration_ssl_units") == 2'000'000);
  CHECK(mentions(left.results.warnings, "tasks.ssl.units = \"auto\": nothing timed them here"));
  const firmware::LiveRunOutcome said = simulated("said.lcm", {"tasks.ssl.units=2000000"});
  CHECK(said.results.digest == left.results.digest);
  CHECK(said.results.counters.count("calibration_ssl_units") == 0);
  CHECK(replay_log(folder.file("auto.lcm")).results.digest == left.results.digest);
}

TEST_CASE("units = auto are for tasks whose units can be tried, and no other word is") {
  const auto refusal = [](const std::string& scene, const std::string& override) {
    return message_of<firmware::ProfileError>([&] {
      const firmware::Runtime runtime(firmware::load_scene(scene, {override}), firmware::own_vehicles(), {});
    });
  };
  CHECK(mentions(refusal("ugv_ssl", "tasks.ssl.units=automatic"), "a whole number, or \"auto\""));
  CHECK(mentions(refusal("ugv_ssl", "tasks.ssl.units=1.5"), "a whole number, or \"auto\""));
  CHECK(mentions(refusal("ugv_ssl", "tasks.ssl.units=0"), "outside 1 .. "));
  CHECK(mentions(refusal("uav_corridor", "tasks.path.units=auto"), "must be a whole number"));
  // Where rays are not scheduled there is nothing to try; the key still holds.
  const firmware::BootedRuntime grid = firmware::boot_runtime(
      firmware::own_vehicles(), "ugv_ssl", {"tasks.ssl.units=auto", "ssl.policy=\"grid\""}, true);
  REQUIRE(grid.chosen.size() == 1);
  CHECK_FALSE(grid.chosen[0].timed);
  CHECK(firmware::units_that_fit({"ssl", 4.0, 1, 1000.0}, 0.8) == 200'000);
  CHECK(firmware::units_that_fit({"ssl", 1e9, 1, 1000.0}, 0.8) == 1);
  CHECK(firmware::units_that_fit({"ssl", 1e-9, 1, 1e7}, 1.0) == 4'000'000'000u);
}

}  // namespace sortie::testing
