// SPDX-License-Identifier: BSD-3-Clause
// A plant and a runtime that know each other by datagrams alone. Here both are in one process, on threads of
// their own; tests/plant_test.py starts two, and kills them.
#include "toolchain/simulate/plant_process.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <mutex>
#include <thread>

#include "firmware_like/link/plant_link.hpp"
#include "firmware_like/log/log_clock.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "tests/drivers/scripted_peer.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

// A port whose two neighbours above are free as well.
std::uint16_t three_free_ports() {
  for (int i = 0; i < 100; ++i) {
    const test::LoopbackSocket first;
    bool good = first.port() <= kMostPlantPort;
    for (int above = 1; above <= 2 && good; ++above) {
      const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      sockaddr_in name{};
      name.sin_family = AF_INET;
      name.sin_port = htons(static_cast<std::uint16_t>(first.port() + above));
      name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      good = ::bind(fd, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0;
      ::close(fd);
    }
    if (good) return first.port();
  }
  FAIL("no three free ports side by side");
  return 0;
}

const std::vector<std::string> kBriskPallet = {"hil.lidar_rows=4", "hil.lidar_columns=90",
                                               "mission.commands=[{at_s=0.3,speed_m_s=0.3},{at_s=60.0}]"};
// The same with a solid-state lidar, and the other one seldom asked.
const std::vector<std::string> kBriskRays = {"hil.lidar_columns=16", "tasks.ssl.units=300000",
                                             "occupancy.window_x_m=19.2", "occupancy.window_y_m=19.2",
                                             "mission.commands=[{at_s=0.3,speed_m_s=0.3},{at_s=60.0}]"};

// A plant on a thread until it is ended.
class PlantThread {
 public:
  PlantThread(std::uint16_t port, const std::string& record, const std::string& scene = "ugv_pallet",
              const std::vector<std::string>& overrides = kBriskPallet)
      : thread_([this, port, record, scene, overrides] {
          PlantOptions options;
          options.scene = scene;
          options.overrides = overrides;
          options.port = port;
          options.record = record;
          options.interrupted = &enough_;
          options.tell = [this](const std::string& line) {
            if (line.find("is heard") != std::string::npos) heard_.store(true);
          };
          outcome_ = run_plant(make_simulated_robot, options);
        }) {}
  ~PlantThread() { static_cast<void>(end()); }
  PlantThread(const PlantThread&) = delete;
  PlantThread& operator=(const PlantThread&) = delete;
  /// Waits until it has met a runtime; however long that takes on a busy machine, within a minute.
  bool wait_until_heard() const {
    for (int i = 0; i < 6000 && !heard_.load(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return heard_.load();
  }
  const PlantOutcome& end() {
    enough_.store(true);
    if (thread_.joinable()) thread_.join();
    return outcome_;
  }

 private:
  std::atomic<bool> enough_{false};
  std::atomic<bool> heard_{false};
  PlantOutcome outcome_;
  std::thread thread_;  // last: it uses all of the above
};

LiveRunOptions against(std::uint16_t port, double seconds, const std::string& record,
                       const std::string& scene = "ugv_pallet",
                       const std::vector<std::string>& overrides = kBriskPallet) {
  LiveRunOptions options;
  options.scene = scene;
  options.overrides = overrides;
  options.seconds = seconds;
  options.realtime = false;
  options.record = record;
  options.lcm_url = "none";
  options.plant = "own:" + std::to_string(port);
  return options;
}

}  // namespace

TEST_CASE(
    "a runtime drives a plant by datagrams, its log replays, and the plant's log tells how well it knew") {
  const TempFolder folder;
  const std::uint16_t port = three_free_ports();
  const bool counts_heap = watch_heap();
  LiveRunOutcome run;
  PlantOutcome plant;
  run = undisturbed(std::chrono::milliseconds(200), [&] {
    PlantThread beside(port, folder.file("plant.lcm"));
    LiveRunOutcome outcome =
        run_live(own_vehicles(), make_simulated_robot, against(port, 3, folder.file("run.lcm")));
    plant = beside.end();
    return outcome;
  });
  const auto& counters = run.results.counters;
  if (counts_heap) CHECK(counters.at("heap_calls") == 0);
  CHECK(counters.at("plant_can_peers") == 1);
  CHECK(counters.at("plant_can_foreign") == 0);
  // How much was driven needs a machine on which the plant keeps up, an emulator may not be one.
  const bool kept_up = plant.counters.at("late_wakes") == 0 && plant.counters.at("bench_late_steps") < 300;
  if (!kept_up)
    WARN("this machine is too slow for a plant in real time; only what must always hold is checked");
  if (kept_up) {
    CHECK(counters.at("plant_can_lost") == 0);
    CHECK(counters.at("imu_used") > 450);
    CHECK(counters.at("track_used") > 230);
    CHECK(counters.at("scans") > 20);
    CHECK(plant.counters.at("bench_commands") > 200);
    CHECK(plant.warnings.empty());
  }
  CHECK(run.truth.empty());  // the runtime does not know it

  ReplayOptions options;
  options.truth = folder.file("plant.lcm");
  const ReplayOutcome replayed = replay_log(folder.file("run.lcm"), options);
  CHECK(complaint_of(replayed).empty());
  CHECK(replayed.results.digest == run.results.digest);
  if (kept_up) {
    CHECK(replayed.truth.size() > 250);
    CHECK(replayed.contacts.size() > 250);
    const auto errors = evaluate(replayed.estimate, replayed.truth).errors;
    CHECK(errors.at("distance_m") > 0.5);
    CHECK(errors.at("ate_max_m") < 0.05);
  }
  CHECK_FALSE(mentions(replayed.results.warnings, "UTC"));

  // The stamps of both are of one clock: what the tracks say they travelled is what the truth did then.
  const ClockOffset offset = clock_offset(LogFile(folder.file("run.lcm")), LogFile(folder.file("plant.lcm")));
  CHECK(offset.exact);

  // Logs that do not belong together, and one without truth.
  CHECK(mentions(message_of<InputError>([&] {
                   options.truth = folder.file("run.lcm");
                   static_cast<void>(replay_log(folder.file("run.lcm"), options));
                 }),
                 "holds no truth"));
  CHECK(mentions(message_of<InputError>([&] {
                   options.truth = folder.file("plant.lcm");
                   static_cast<void>(replay_log(two_seconds().log, options));
                 }),
                 "does not say when"));
}

TEST_CASE("rays go out to a plant and what comes back is mapped, and the log replays") {
  const TempFolder folder;
  const std::uint16_t port = three_free_ports();
  const bool counts_heap = watch_heap();
  PlantOutcome plant;
  const LiveRunOutcome run = undisturbed(std::chrono::milliseconds(200), [&] {
    PlantThread beside(port, folder.file("plant.lcm"), "ugv_ssl", kBriskRays);
    LiveRunOutcome outcome = run_live(own_vehicles(), make_simulated_robot,
                                      against(port, 3, folder.file("run.lcm"), "ugv_ssl", kBriskRays));
    plant = beside.end();
    return outcome;
  });
  const auto ran = [&run](const char* name) { return run.results.counters.at(name); };
  const auto fired = [&plant](const char* name) { return plant.counters.at(name); };
  if (counts_heap) CHECK(ran("heap_calls") == 0);
  CHECK(ran("plant_ssl_peers") == 1);
  for (const char* never : {"plant_rays_malformed", "plant_rays_unasked", "plant_rays_repeated",
                            "plant_rays_overtaken", "plant_rays_mismatched", "plant_ssl_foreign"})
    CHECK(ran(never) == 0);
  CHECK(fired("rays_malformed") == 0);
  CHECK(fired("rays_repeated") == 0);
  CHECK(ran("plant_rays_commands") == ran("ssl_commands_sent"));
  CHECK(ran("ssl_frames") + ran("ssl_unasked") <= ran("plant_rays_frames"));
  const bool kept_up = plant.counters.at("late_wakes") == 0 && plant.counters.at("bench_late_steps") < 300;
  if (!kept_up)
    WARN("this machine is too slow for a plant in real time; only what must always hold is checked");
  if (kept_up) {
    CHECK(ran("ssl_frames") > 20);
    CHECK(ran("ssl_unasked") == 0);
    CHECK(ran("occupancy_known") > 1000);
    // What the last command asks for may be left over when the run ends.
    CHECK(fired("rays_commands") >= fired("bench_ssl_rays") / 200);
    CHECK(fired("rays_commands") <= fired("bench_ssl_rays") / 200 + 1);
    CHECK(fired("rays_frames") <= fired("rays_commands"));
  }
  const ReplayOutcome replayed = replay_log(folder.file("run.lcm"));
  CHECK(complaint_of(replayed).empty());
  CHECK(replayed.results.digest == run.results.digest);
  CHECK(replayed.results.counters.at("ssl_frames") == ran("ssl_frames"));
}

TEST_CASE("without a plant the robot stands, and the run says so, and a plant may come later") {
  const std::uint16_t port = three_free_ports();
  const LiveRunOutcome alone = run_live(own_vehicles(), make_simulated_robot, against(port, 0.4, ""));
  CHECK(mentions(alone.results.warnings, "no plant was heard on port " + std::to_string(port)));
  CHECK(alone.results.counters.at("imu_used") == 0);
  CHECK(alone.results.counters.at("commands_refused") > 0);

  // Long enough that a plant which comes late is heard, on a machine however busy.
  LiveRunOptions options = against(port, 600, "");
  std::atomic<bool> enough{false};
  options.interrupted = &enough;
  LiveRunOutcome run;
  std::thread runtime([&] { run = run_live(own_vehicles(), make_simulated_robot, options); });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  PlantOutcome last;
  for (int life = 0; life < 2; ++life) {
    PlantThread plant(port, "");
    CHECK(plant.wait_until_heard());
    std::this_thread::sleep_for(std::chrono::milliseconds(1000));
    last = plant.end();
  }
  enough.store(true);
  runtime.join();
  CHECK(last.counters.at("can_peers") == 1);
  CHECK(last.counters.at("bench_commands") > 0);
  CHECK(run.results.counters.at("plant_can_peers") == 2);
  CHECK(run.results.counters.at("imu_used") > 0);
  CHECK(mentions(run.results.warnings, "the plant was restarted 1 times"));
  CHECK(mentions(run.results.warnings, "went silent"));
}

TEST_CASE("where a plant runs is checked, and it keeps its port to itself") {
  CHECK(parse_plant("own") == kPlantPort);
  CHECK(parse_plant("own:2000") == 2000);
  CHECK(parse_plant("own:65533") == kMostPlantPort);
  for (const char* text :
       {"", "mine", "own:", "own:0", "own:1023", "own:65534", "own:65535", "own:70000", "own:20x", "own: 20"})
    CHECK_THROWS_AS(parse_plant(text), ProfileError);
  LiveRunOptions options = against(kPlantPort, 1, "");
  options.virtual_time = true;
  CHECK(mentions(message_of<ProfileError>([&] { run_live(own_vehicles(), make_simulated_robot, options); }),
                 "--virtual has its plant inside"));
  const test::LoopbackSocket taken;
  PlantOptions plant;
  plant.scene = "ugv_pallet";
  plant.seconds = 0.01;
  plant.port = taken.port();
  CHECK(mentions(message_of<ProfileError>([&] { run_plant(make_simulated_robot, plant); }),
                 "is another plant running"));
  plant.scene = "imu_bench";
  CHECK(
      mentions(message_of<ProfileError>([&] { run_plant(make_simulated_robot, plant); }), "simulated robot"));
}

TEST_CASE("logs are laid side by side by the machine's clock, else by their dates") {
  const TempFolder folder;
  const auto write_log = [&](const std::string& name, std::int64_t utc, const char* boot, std::int64_t zero) {
    drivers::LcmLogWriter writer(folder.file(name));
    drivers::LogHeader header;
    header.utc_minus_monotonic_ns = utc;
    std::vector<std::uint8_t> bytes(4096);
    std::size_t size = 0;
    REQUIRE(drivers::encode(header, bytes, size) == Status::ok);
    REQUIRE(writer.append(drivers::kChannelHeader, 0, {bytes.data(), size}) == Status::ok);
    if (boot != nullptr) {
      REQUIRE(drivers::encode(drivers::EventRecord{0, 0, "clock", boot, zero, ""}, bytes, size) ==
              Status::ok);
      REQUIRE(writer.append(drivers::kChannelEvent, 0, {bytes.data(), size}) == Status::ok);
    }
    REQUIRE(writer.close() == Status::ok);
    return LogFile(folder.file(name));
  };
  const LogFile run = write_log("a", 1'000'000'000'000, "boot-1", 5'000'000'000);
  const LogFile same = write_log("b", 1'000'200'000'000, "boot-1", 5'000'000'123);
  CHECK(clock_offset(run, same).exact);
  CHECK(clock_offset(run, same).offset_ns == 123);
  CHECK(clock_offset(same, run).offset_ns == -123);
  const LogFile other = write_log("c", 1'000'200'000'000, "boot-2", 5'000'000'123);
  CHECK_FALSE(clock_offset(run, other).exact);
  CHECK(clock_offset(run, other).offset_ns == 200'000'000);
  const LogFile silent = write_log("d", 0, nullptr, 0);
  CHECK(mentions(message_of<InputError>([&] { static_cast<void>(clock_offset(run, silent)); }),
                 "does not say when"));
}
