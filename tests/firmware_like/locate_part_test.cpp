// SPDX-License-Identifier: BSD-3-Clause
// The part that locates the robot on its own map: beside the odometry and the local map, and with a lidar
// alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>

#include "drivers/wire.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "mapping/registration/surfel_map.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {
namespace {

firmware::LiveRunOutcome run_located(double seconds, const std::string& log, std::vector<std::string> more,
                                     const std::string& map = "") {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = std::move(more);
  options.overrides.insert(options.overrides.end(), {"hil.lidar_rows=16", "hil.lidar_columns=180",
                                                     "limits.voxels=65536", "tasks.map.budget_us=20000"});
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.map = map;
  options.record_fields = true;
  options.lcm_url = "none";
  firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  static_cast<void>(toolchain::judge(run));
  return run;
}

std::uint64_t counted(const firmware::LiveRunOutcome& run, const std::string& name) {
  return run.results.counters.at(name);
}

double error_of(const firmware::Results& results, const std::string& name) { return results.errors.at(name); }

bool same(const firmware::Trajectory& a, const firmware::Trajectory& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.stamp_ns == y.stamp_ns && std::equal(x.p, x.p + 3, y.p) && std::equal(x.q, x.q + 4, y.q);
  });
}

/// A drive of 8 s with map, recorded once a program.
struct LocatedHall {
  TempFolder folder;
  std::string log = folder.file("located.lcm");
  firmware::LiveRunOutcome run = run_located(8, log, {"tasks.locate.enabled=true"});
};
const LocatedHall& located_hall() {
  static const LocatedHall recorded;
  return recorded;
}

std::vector<std::uint8_t> map_bytes(const firmware::Runtime& runtime) {
  const mapping::ScanRegistration* map = runtime.vehicle().surfels();
  REQUIRE(map != nullptr);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::surfel_map_bytes(*map)));
  REQUIRE(mapping::write_surfel_map(*map, bytes) == Status::ok);
  return bytes;
}

/// Writes the map at the end of a log; gives its bytes.
std::vector<std::uint8_t> keep_map(const std::string& log, const std::string& path) {
  std::vector<std::uint8_t> bytes = map_bytes(*replay_log(log, {}).runtime);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  return bytes;
}

std::string refusal_of(const std::string& log, const firmware::ReplayOptions& options) {
  return message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); });
}

/// The log of a lidar alone, with the truth that judges it. `pose` may give each scan one.
void keep_lidar(const std::string& from, const std::string& to,
                const std::function<void(rt::ScanHeader&)>& pose = nullptr) {
  rewrite_log(from, to, [&pose](EditableEvent& event, std::size_t) {
    if (event.channel == drivers::kChannelHeader || event.channel == drivers::kChannelTruth) return true;
    if (event.channel != drivers::kChannelScan) return false;
    if (!pose) return true;
    rt::ScanHeader header;
    std::int64_t seq = 0;
    std::vector<rt::ScanPoint> points(event.bytes.size() / drivers::kScanPointBytes);
    REQUIRE(drivers::decode(event.bytes, header, points, seq) == Status::ok);
    pose(header);
    std::size_t size = 0;
    REQUIRE(drivers::encode(rt::PointScan{header, points.data()}, seq, event.bytes, size) == Status::ok);
    return true;
  });
}

firmware::ReplayOptions as_lidar(std::vector<std::string> overrides = {}) {
  firmware::ReplayOptions options;
  options.scene = "lidar_walk";
  options.overrides = std::move(overrides);
  options.overrides.emplace_back("lidar.z_m=0.45");  // as ugv_hall has it
  options.overrides.emplace_back("lidar.x_m=0.05");
  options.accept_unused = true;
  return options;
}

firmware::ReplayOutcome replay_lidar(const std::string& log, std::vector<std::string> overrides = {}) {
  firmware::ReplayOutcome outcome = replay_log(log, as_lidar(std::move(overrides)));
  static_cast<void>(toolchain::judge(outcome));
  return outcome;
}

}  // namespace

TEST_CASE("a robot that drives is located scan by scan, and its replay comes to the same") {
  const firmware::LiveRunOutcome& run = located_hall().run;
  CHECK(counted(run, "locate_in") == counted(run, "scans"));
  CHECK(counted(run, "locate_first") == 1);
  CHECK(counted(run, "locate_accepted") == counted(run, "locate_in") - 1);
  CHECK(counted(run, "locate_unplaced") == 0);
  if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);
  CHECK(run.located.size() == counted(run, "locate_in"));
  CHECK(error_of(run.results, "located_ate_max_m") < 0.05);
  CHECK(error_of(run.results, "located_distance_m") > 2.0);
  firmware::ReplayOptions options;
  std::uint64_t told = 0;
  rt::LocatedPose newest;
  options.on_job = [&](const rt::JobRecord&, firmware::Runtime& runtime) {
    while (runtime.parts().find<firmware::ReportQueue<rt::LocatedPose>>()->take(newest)) ++told;
  };
  firmware::ReplayOutcome again = replay_log(located_hall().log, options);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  CHECK(same(again.located, run.located));
  // Every scan is told but what came before somebody listened.
  CHECK(told + 1 >= counted(run, "locate_in"));
  const rt::LocatedPose& last = again.runtime->vehicle().located_task()->value();
  CHECK(newest.stamp_ns == last.stamp_ns);
  CHECK(last.is_placed());
  CHECK(last.scans == counted(run, "locate_in"));
  CHECK(last.covariance[0] > 0.0);
}

TEST_CASE(
    "beside it nothing changes: the odometry's path is the same to the bit, and the local map has the same "
    "scans") {
  const TempFolder folder;
  const firmware::LiveRunOutcome without = run_located(8, folder.file("without.lcm"), {});
  const firmware::LiveRunOutcome& with = located_hall().run;
  CHECK(without.located.empty());
  CHECK(without.results.errors.count("located_ate_rmse_m") == 0);
  CHECK(same(without.estimate, with.estimate));
  for (const char* name : {"scans", "points_in", "points_on_robot", "scans_unplaced"}) {
    INFO(name);
    CHECK(counted(with, name) == counted(without, name));
  }
  // Returns that straightening moves over the edge of the map's ranges are judged by another place.
  CHECK(static_cast<double>(counted(with, "points_used")) ==
        Approx(static_cast<double>(counted(without, "points_used"))).epsilon(0.002));
}

TEST_CASE("with two scans a job both are located, each by its own returns") {
  const TempFolder folder;
  // Four buffers are too few for two scans a job and those that a job still reads.
  const std::vector<std::string> fast = {"tasks.locate.enabled=true", "hil.lidar_hz=20",
                                         "limits.scan_buffers=8", "map.segments=\"off\""};
  const firmware::LiveRunOutcome run = run_located(5, folder.file("fast.lcm"), fast);
  CHECK(counted(run, "locate_in") == counted(run, "scans"));
  CHECK(counted(run, "locate_in") > 90);
  CHECK(counted(run, "locate_accepted") + 1 == counted(run, "locate_in"));
  auto alone = fast;
  alone.insert(alone.end(), {"tasks.map.enabled=false", "scene.unknown_keys=ignore"});
  const firmware::LiveRunOutcome mapless = run_located(5, folder.file("alone.lcm"), alone);
  CHECK(counted(mapless, "locate_accepted") + 1 == counted(mapless, "locate_in"));
  CHECK(error_of(mapless.results, "located_ate_max_m") < 0.05);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.05);
}

TEST_CASE("a lidar's log without poses and without odometry gives a trajectory") {
  const TempFolder folder;
  const std::string log = folder.file("lidar.lcm");
  keep_lidar(located_hall().log, log);
  const firmware::ReplayOutcome outcome = replay_lidar(log);
  CHECK(outcome.estimate.empty());
  CHECK(outcome.located.size() >= located_hall().run.located.size() - 1);
  // A scan that alone leaves its pose open is refused.
  CHECK(20 * (counter(outcome, "locate_accepted") + 1) > 19 * counter(outcome, "locate_in"));
  // A sweep takes a tenth of a second, and nothing is there to straighten it.
  CHECK(error_of(outcome.results, "located_ate_max_m") < 0.15);
  CHECK(error_of(outcome.results, "located_distance_m") > 2.0);
  CHECK(outcome.results.errors.count("ate_rmse_m") == 0);
  CHECK(replay_lidar(log).results.digest == outcome.results.digest);
}

TEST_CASE("poses that come with scans are the odometry, unless a scene will not have them") {
  const TempFolder folder;
  const std::string log = folder.file("posed.lcm");
  // Where the scans say that they are is 100 m away, and turned.
  const rt::Quaternion turn = rt::from_yaw_pitch_roll(1.0, 0.0, 0.0);
  const rt::Quaternion level = rt::from_yaw_pitch_roll(0.0, 0.0, 0.0);
  const firmware::Trajectory& way = located_hall().run.located;
  keep_lidar(located_hall().log, log, [&](rt::ScanHeader& header) {
    const auto at = std::lower_bound(way.begin(), way.end(), header.stamp_ns,
                                     [](const auto& pose, auto stamp) { return pose.stamp_ns < stamp; });
    const firmware::TimedPose& body = at == way.end() ? way.back() : *at;
    const rt::Quaternion q = rt::to_quaternion(body.q);
    const rt::Vector3 p = rt::to_vector(body.p) + rt::rotate(q, {0.05, 0.0, 0.45});
    header.flags |= rt::kScanPosed;
    rt::store(rt::Vector3{100, 0, 0} + rt::rotate(turn, p), header.p_world_sensor_m);
    rt::store(turn * q * level, header.q_world_sensor);
  });
  const firmware::ReplayOutcome posed = replay_lidar(log, {"locate.scan_poses=true"});
  CHECK(counter(posed, "locate_accepted") + 1 == counter(posed, "locate_in"));
  const rt::LocatedPose& last = posed.runtime->vehicle().located_task()->value();
  CHECK(rt::norm(rt::to_vector(last.p_map_body_m) - rt::Vector3{100, 0, 0}) < 10.0);
  CHECK(rt::norm(rt::to_vector(last.p_map_odom_m)) < 1.0);
  const firmware::ReplayOutcome unposed = replay_lidar(log);
  CHECK(rt::norm(rt::to_vector(unposed.runtime->vehicle().located_task()->value().p_map_body_m)) < 10.0);
}

TEST_CASE("a log with it is indexed, and a replay from a keyframe ends in the same state as the whole one") {
  const TempFolder folder;
  const std::string alone = folder.file("lidar.lcm");
  keep_lidar(located_hall().log, alone);
  for (const bool lidar_alone : {false, true}) {
    INFO("lidar alone " << lidar_alone);
    const std::string& log = lidar_alone ? alone : located_hall().log;
    firmware::ReplayOptions options = lidar_alone ? as_lidar() : firmware::ReplayOptions{};
    options.keyframes = folder.file("of.keyframes");
    const Indexed full = replay_and_keep(log, firmware::own_vehicles(), options, 500, options.keyframes);
    for (const rt::Tick from : {rt::Tick{700}, rt::Tick{4200}}) {
      options.from = "@" + std::to_string(from);
      const Indexed part = replay_and_keep(log, firmware::own_vehicles(), options, 500);
      CHECK(part.outcome.restored_tick == from / 500 * 500);
      CHECK(part.outcome.results.digest == full.outcome.results.digest);
      CHECK(counter(part.outcome, "locate_accepted") == counter(full.outcome, "locate_accepted"));
      for (const auto& [tick, state] : part.states) {
        INFO("state at tick " << tick);
        CHECK((state == full.states.at(tick)));
      }
    }
  }
}

TEST_CASE("a run begins with the map of another, and its log replays with that map alone") {
  const TempFolder folder;
  const std::string map = folder.file("hall.surfels");
  const std::string other = folder.file("other.surfels");
  const std::vector<std::uint8_t> bytes = keep_map(located_hall().log, map);
  {
    std::vector<std::uint8_t> of_less = bytes;  // any other file
    of_less.push_back(0);
    std::ofstream(other, std::ios::binary)
        .write(reinterpret_cast<const char*>(of_less.data()), static_cast<std::streamsize>(of_less.size()));
  }
  const std::vector<std::string> wanted = {"tasks.locate.enabled=true"};
  for (const bool start_on_map : {false, true}) {
    INFO("start_on_map " << start_on_map);
    const std::string log = folder.file(start_on_map ? "placed.lcm" : "unplaced.lcm");
    auto keys = wanted;
    if (start_on_map) keys.emplace_back("locate.start_on_map=true");
    const firmware::LiveRunOutcome run = run_located(4, log, keys, map);
    CHECK(counted(run, "locate_in") > 30);
    CHECK(counted(run, "locate_first") == 0);
    CHECK(counted(run, start_on_map ? "locate_accepted" : "locate_unplaced_on_map") ==
          counted(run, "locate_in"));
    CHECK(run.failures.empty());
    if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);
    if (start_on_map) {
      CHECK(run.located.size() == counted(run, "locate_in"));
      CHECK(error_of(run.results, "located_ate_max_m") < 0.05);
    } else {
      CHECK(run.located.empty());  // of no scan is anything known
      CHECK(run.results.errors.count("located_ate_rmse_m") == 0);
      CHECK(map_bytes(*run.runtime) == bytes);
    }
    firmware::ReplayOptions options;
    const std::string without = refusal_of(log, options);
    CHECK(mentions(without, "begins with the map hall.surfels (digest "));
    CHECK(mentions(without, "--map FILE"));
    options.map = other;
    CHECK(mentions(refusal_of(log, options), "begins with the map hall.surfels (digest "));
    CHECK(mentions(refusal_of(log, options), "is another one"));
    options.map = map;
    const firmware::ReplayOutcome again = replay_log(log, options);
    CHECK(complaint_of(again).empty());
    CHECK(again.comparable);
    CHECK(again.results.digest == run.results.digest);
    CHECK(map_bytes(*again.runtime) == map_bytes(*run.runtime));
  }
}

TEST_CASE("a robot that is told nothing finds its place on the map of another run, and replays to the bit") {
  const TempFolder folder;
  const std::string map = folder.file("hall.surfels");
  const std::string log = folder.file("found.lcm");
  keep_map(located_hall().log, map);
  // Jobs of few units: a search takes several of them while the robot drives on.
  const std::vector<std::string> wanted = {"tasks.locate.enabled=true", "tasks.relocate.enabled=true",
                                           "relocate.units=1000000", "tasks.relocate.budget_us=10000",
                                           "relocate.second_look_m=0.2"};
  const firmware::LiveRunOutcome run = run_located(9, log, wanted, map);
  CHECK(run.failures.empty());
  CHECK(counted(run, "relocate_placed") >= 2);  // from two places
  CHECK(counted(run, "relocate_first_looks") == 1);
  CHECK(counted(run, "relocate_disagreed") == 0);
  CHECK(counted(run, "relocate_not_confirmed") == 0);
  CHECK(counted(run, "locate_unplaced_on_map") >= 2);
  CHECK(counted(run, "locate_accepted") + counted(run, "locate_unplaced_on_map") ==
        counted(run, "locate_in"));
  CHECK(error_of(run.results, "located_ate_max_m") < 0.05);
  if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);
  firmware::ReplayOptions options;
  options.map = map;
  const firmware::ReplayOutcome again = replay_log(log, options);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  // Nothing is searched where the robot makes its map itself.
  const firmware::LiveRunOutcome own = run_located(2, "", wanted);
  CHECK(counted(own, "relocate_begun") == 0);
}

TEST_CASE("a map that does not fit the scene is refused with the key to set") {
  const TempFolder folder;
  const std::string map = folder.file("hall.surfels");
  const std::vector<std::uint8_t> bytes = keep_map(located_hall().log, map);
  const auto why = [&](std::vector<std::string> keys, const std::string& file) {
    std::string said;
    try {
      static_cast<void>(run_located(1, "", std::move(keys), file));
    } catch (const std::exception& error) {
      said = error.what();
    }
    INFO(said);
    CHECK(mentions(said, file));
    return said;
  };
  const std::string on = "tasks.locate.enabled=true";
  CHECK(mentions(why({on, "locate.cell_m=0.4"}, map), "cure: --set locate.cell_m=0.5"));
  CHECK(mentions(why({on, "locate.min_points=8"}, map), "cure: --set locate.min_points=5"));
  CHECK(mentions(why({on, "limits.surfels=300"}, map), "cure: --set limits.surfels="));
  CHECK(mentions(why({on, "locate.window_cells=16"}, map), "cure: --set locate.window_cells="));
  CHECK(mentions(why({on, "locate.window_cells_up=8"}, map), "cure: --set locate.window_cells_up="));
  CHECK(mentions(why({}, map), "has no part that uses a map of surfaces"));
  CHECK(mentions(why({on}, folder.file("none.surfels")), "sortie export surfels"));
  CHECK(mentions(why({on}, located_hall().log), "is no map of surfaces"));
  std::filesystem::resize_file(map, bytes.size() - 9);
  CHECK(mentions(why({on}, map), "cut off"));
  const std::string uneven = message_of<firmware::ProfileError>([&] {
    static_cast<void>(run_located(1, "", {on, "locate.window_cells=100"}));
  });
  CHECK(mentions(uneven, "a power of two: 64 or 128"));
}

TEST_CASE("a scene that does not ask for it has neither its task nor its memory") {
  for (const firmware::BuiltInScene& scene : firmware::built_in_scenes()) {
    const firmware::Runtime runtime(firmware::load_scene(scene.name), firmware::own_vehicles(),
                                    firmware::RuntimeStart{});
    INFO(scene.name);
    const std::string name = scene.name;
    const bool asks = name == "ugv_locate" || name == "lidar_walk" || name == "lidar_plane";
    CHECK((runtime.vehicle().located_task() != nullptr) == asks);
  }
}

}  // namespace sortie::testing
