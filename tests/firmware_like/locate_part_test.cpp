// SPDX-License-Identifier: BSD-3-Clause
// The part that locates the robot on its own map: beside the odometry and the local map, and with a lidar
// alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "drivers/wire.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/scene_parts.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/located_rig.hpp"

namespace sortie::testing {
namespace {

bool same(const firmware::Trajectory& a, const firmware::Trajectory& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
    return x.stamp_ns == y.stamp_ns && std::equal(x.p, x.p + 3, y.p) && std::equal(x.q, x.q + 4, y.q);
  });
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
    auto& queue = *runtime.parts().find<firmware::ReportQueue<rt::LocatedPose>>();
    for (; const rt::LocatedPose* const pose = queue.front(); queue.pop(), ++told) newest = *pose;
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

TEST_CASE("a lidar's log without poses and without odometry gives a trajectory", "[heavy]") {
  const TempFolder folder;
  const std::string log = folder.file("lidar.lcm");
  keep_lidar(located_hall().log, log);
  const firmware::ReplayOutcome outcome = replay_lidar(log);
  CHECK(outcome.estimate.empty());
  CHECK(outcome.located.size() >= located_hall().run.located.size() - 1);
  // Without odometry one that hardly anything speaks against is refused as well.
  CHECK(counter(outcome, "locate_accepted") + 2 >= counter(outcome, "locate_in"));
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

TEST_CASE("a log with it is indexed, and a replay from a keyframe ends in the same state as the whole one",
          "[heavy]") {
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

TEST_CASE("a scene that does not ask for it has neither its task nor its memory") {
  for (const firmware::BuiltInScene& scene : firmware::built_in_scenes()) {
    const firmware::Runtime runtime(firmware::load_scene(scene.name), firmware::own_vehicles(),
                                    firmware::RuntimeStart{});
    INFO(scene.name);
    const std::string name = scene.name;
    const bool asks =
        name == "ugv_locate" || name == "ugv_goal" || name == "lidar_walk" || name == "lidar_plane";
    CHECK((runtime.vehicle().located_task() != nullptr) == asks);
  }
}

}  // namespace sortie::testing
