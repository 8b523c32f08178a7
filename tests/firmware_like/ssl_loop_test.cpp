// SPDX-License-Identifier: BSD-3-Clause
// The loop of map, ray scheduler and device inside the runtime, beside a twin that calls the parts by hand.
#include <catch2/catch.hpp>

#include "planner/ssl_horizon.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/ssl_rig.hpp"

namespace sortie::testing {
namespace {

struct StandingRun {
  SslTraffic traffic;
  firmware::LiveRunOutcome outcome;
};

void run_standing(StandingRun& run, const std::string& scene, const std::string& log,
                  std::vector<std::string> overrides = {}) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = std::move(overrides);
  options.seconds = 3;
  options.virtual_time = true;
  options.record = log;
  options.record_fields = true;
  options.lcm_url = "none";
  run.traffic.commands.reserve(64);
  run.traffic.answers.reserve(64);
  const firmware::SimulatorFactory simulator = [&run](firmware::Profile&, drivers::ScanSink*) {
    return std::make_unique<SslBench>(run.traffic);
  };
  run.outcome = firmware::run_live(standing_vehicles(), simulator, options);
}

std::uint64_t stands(const StandingRun& run, const std::string& name) {
  return run.outcome.results.counters.at(name);
}

// What the runtime should ask for, from the answers that came: map, poses and scheduler called in a loop.
class SslTwin {
 public:
  explicit SslTwin(firmware::Profile profile)
      : settings_(firmware::read_ssl_settings(profile)),
        occupancy_(firmware::read_occupancy_settings(profile, settings_)),
        mount_(firmware::read_ssl_mount(profile)),
        cells_(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(occupancy_.map))),
        map_(occupancy_.map, cells_),
        memory_(static_cast<std::size_t>(planner::SslChoice::memory_bytes(settings_.choice))),
        choice_(settings_.choice, memory_) {}

  rt::SslCommand job(std::uint64_t number, const SslTraffic& traffic, std::uint64_t units) {
    const rt::Nanoseconds now = static_cast<rt::Nanoseconds>(number) * 100'000'000;
    const rt::Vector3 p = rt::to_vector(StandingVehicle::place().p_world_body_m);
    const rt::Vector3 sensor = p + rt::to_vector(mount_.place_m);
    if (number > 0) (void)map_.centre_on(p);
    for (; next_ < traffic.answers.size() && traffic.answers[next_].at <= now; ++next_)
      enter(traffic.answers[next_].returns, sensor);
    const mapping::SensorPose poses[3] = {{sensor, {}}, {sensor, {}}, {sensor, {}}};
    if (number > 0) REQUIRE(choice_.begin(map_.view(), poses, number > 1 ? 1 : 3) == Status::ok);
    (void)choice_.step(units);
    rt::SslCommand command;
    choice_.choose(now + 100'000'000, command);
    asked_ = command.number;
    return command;
  }
  std::uint64_t known() const { return map_.output().known; }

 private:
  void enter(const rt::SslReturns& returns, const rt::Vector3& from) {
    if (returns.number <= answered_ || returns.number > asked_) return;
    answered_ = returns.number;
    for (std::uint32_t i = 0; i < returns.rays; ++i) {
      const bool hit = returns.range_mm[i] > 0;
      const double range_m = hit ? rt::kSslRangeStep_m * returns.range_mm[i] : 12.0;
      (void)map_.update_ray(from, from + range_m * rt::ssl_direction(returns.direction[i]), hit);
    }
  }

  firmware::SslSettings settings_;
  firmware::OccupancySettings occupancy_;
  firmware::SensorMount mount_;
  std::vector<std::int8_t> cells_;
  mapping::OccupancyMap map_;
  std::vector<std::byte> memory_;
  planner::SslChoice choice_;
  std::size_t next_{};
  std::uint32_t asked_{};
  std::uint32_t answered_{};
};

void check_against_twin(const StandingRun& run, const std::string& scene, std::uint64_t units) {
  SslTwin twin(firmware::load_scene(scene, {}));
  REQUIRE(run.traffic.commands.size() == 29);
  for (std::size_t job = 0; job < 29; ++job) {
    CAPTURE(job);
    const rt::SslCommand expected = twin.job(job, run.traffic, units);
    const rt::SslCommand& sent = run.traffic.commands[job];
    REQUIRE(sent.number == expected.number);
    REQUIRE(sent.stamp_ns == expected.stamp_ns);
    REQUIRE(sent.rays == expected.rays);
    REQUIRE(std::equal(sent.direction, sent.direction + sent.rays, expected.direction));
  }
  static_cast<void>(twin.job(29, run.traffic, units));
  CHECK(stands(run, "occupancy_known") == twin.known());
}

}  // namespace

TEST_CASE("the rays that leave are the plan over the map of what came back, whatever the link does") {
  const TempFolder folder;
  const std::string scene = standing_scene(folder);
  StandingRun run;
  run_standing(run, scene, folder.file("standing.lcm"));
  check_against_twin(run, scene, 400'000);
  // Of 28 commands whose answers can come: 3, 10, 17, 24 are lost, 4, 11, 18, 25 overtaken, 5, 12, 19, 26
  // come twice, 6, 13, 20, 27 beside one that nobody asked for.
  CHECK(stands(run, "ssl_commands_sent") == 29);
  CHECK(stands(run, "ssl_frames") == 28 - 4 - 4);
  CHECK(stands(run, "ssl_unasked") == 3 * 4);
  CHECK(stands(run, "ssl_unplaced") == 0);
  CHECK(stands(run, "ssl_unplanned") == 1);  // the first job knows no place yet
  CHECK(stands(run, "occupancy_known") > 1000);
  if (rt::posix::kHeapTrapAvailable) CHECK(stands(run, "heap_calls") == 0);
}

TEST_CASE("with next to no units strides are asked for, and a loop without a map needs no pose") {
  const TempFolder folder;
  const std::string scene = standing_scene(folder);
  StandingRun poor;
  run_standing(poor, scene, "", {"tasks.ssl.units=1"});
  check_against_twin(poor, scene, 0);
  CHECK(stands(poor, "ssl_unplanned") == 30);
  StandingRun even;
  run_standing(even, scene, "", {"ssl.policy=\"grid\""});
  CHECK(stands(even, "ssl_frames") == 20);
  CHECK(stands(even, "ssl_unasked") == 12);
  CHECK(even.outcome.results.counters.count("occupancy_known") == 0);
  for (const rt::SslCommand& command : even.traffic.commands)
    REQUIRE(std::equal(command.direction, command.direction + 50, even.traffic.commands[0].direction));
}

TEST_CASE("a log with scheduled rays replays from its start, in threads and from a keyframe") {
  const TempFolder folder;
  const std::string log = folder.file("standing.lcm");
  StandingRun run;
  run_standing(run, standing_scene(folder), log);
  const Indexed full = replay_and_keep(log, standing_vehicles(), {}, 250, firmware::keyframe_path(log));
  CHECK(complaint_of(full.outcome).empty());
  CHECK(full.outcome.results.digest == run.outcome.results.digest);
  firmware::ReplayOptions options;
  options.from = "@1300";
  const firmware::LogFile file(log);
  const firmware::ReplayOutcome part = firmware::replay(file, standing_vehicles(), options);
  CHECK(part.restored_tick == 1250);
  CHECK_FALSE(part.divergence);
  CHECK(part.results.digest == run.outcome.results.digest);
  firmware::ReplayOptions threads;
  threads.threaded = true;
  const firmware::ReplayOutcome parallel = firmware::replay(file, standing_vehicles(), threads);
  CHECK(complaint_of(parallel).empty());
  CHECK(parallel.results.digest == run.outcome.results.digest);
}

TEST_CASE("a scene without a solid-state lidar has no map for it, nor keys") {
  const auto bytes_of = [](const std::string& scene, const std::string& pool,
                           std::vector<std::string> overrides = {}) {
    const firmware::Runtime runtime(firmware::load_scene(scene, overrides), firmware::own_vehicles(), {});
    std::uint64_t bytes = 0;
    for (const firmware::PoolResult& one : runtime.memory_plan()) bytes += one.name == pool ? one.bytes : 0;
    return bytes;
  };
  CHECK(bytes_of("ugv_ssl", "occupancy") == 192 * 128 * 32);
  CHECK(bytes_of("ugv_ssl", "ray scheduler") > 1'000'000);
  for (const char* pool : {"occupancy", "ray scheduler"}) {
    CHECK(bytes_of("ugv_pallet", pool) == 0);
    CHECK(bytes_of("ugv_ssl", pool, {"ssl.policy=\"random\""}) == 0);
  }
  const auto refusal = [](const std::string& scene, const std::string& override) {
    return message_of<firmware::ProfileError>([&] {
      const firmware::Runtime runtime(firmware::load_scene(scene, {override}), firmware::own_vehicles(), {});
    });
  };
  CHECK(mentions(refusal("ugv_pallet", "ssl.rays=100"), "unknown key ssl.rays"));
  CHECK(mentions(refusal("ugv_ssl", "ssl.positions=17"), "ssl.positions"));
  CHECK(mentions(refusal("ugv_ssl", "ssl.rays=257"), "ssl.rays"));
  CHECK(mentions(refusal("ugv_ssl", "ssl.policy=\"best\""), "ssl.policy"));
  CHECK(mentions(refusal("ugv_ssl", "occupancy.voxel_m=0.02"), "occupancy.voxel_m"));
  CHECK(mentions(refusal("ugv_ssl", "occupancy.max_range_m=0.2"), "occupancy.max_range_m"));
  CHECK(mentions(refusal("ugv_ssl", "tasks.odometry.enabled=false"), "needs poses"));
}

TEST_CASE("units that do not fit into their budget are told with those that would") {
  firmware::UnitTrial trial{"ssl", 4.0, 1'000'000, 4000.0};
  CHECK(firmware::unit_warning(trial).empty());
  trial.ns_per_unit = 8.0;
  const std::string warning = firmware::unit_warning(trial);
  CHECK(mentions(warning, "1000000 units of task ssl take about 8000 us"));
  CHECK(mentions(warning, "--set tasks.ssl.units=500000"));
  trial.task.clear();
  CHECK(firmware::unit_warning(trial).empty());
  // The vehicle tries where it schedules, and nowhere else.
  const firmware::Runtime with(firmware::load_scene("ugv_ssl", {}), firmware::own_vehicles(), {});
  const firmware::UnitTrial tried = with.vehicle().try_units();
  CHECK(tried.task == "ssl");
  CHECK(tried.units == 2'000'000);
  CHECK(tried.ns_per_unit > 0.0);
  const firmware::Runtime without(firmware::load_scene("ugv_ssl", {"ssl.policy=\"grid\""}),
                                  firmware::own_vehicles(), {});
  CHECK(without.vehicle().try_units().task.empty());
}

}  // namespace sortie::testing
