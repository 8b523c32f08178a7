// SPDX-License-Identifier: BSD-3-Clause
// The local map in the runtime: what a profile chooses, budgets, replays, and what sweeps become.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <memory>
#include <set>

#include "rt/segment_list.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"

namespace sortie::testing {
namespace {

firmware::LiveRunOutcome run_map(const std::string& scene, double seconds, const std::string& log,
                                 std::vector<std::string> overrides) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = scene;
  options.overrides = std::move(overrides);
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.record_fields = true;
  options.lcm_url = "none";
  return firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
}

std::vector<std::string> hall_with(std::vector<std::string> more) {
  more.insert(more.end(), {"hil.lidar_rows=8", "hil.lidar_columns=128", "limits.voxels=32768"});
  return more;
}

std::vector<firmware::VoxelOnMap> voxels_of(const firmware::ReplayOutcome& outcome) {
  std::vector<firmware::VoxelOnMap> voxels;
  outcome.runtime->vehicle().for_each_voxel(
      [&voxels](const firmware::VoxelOnMap& voxel) { voxels.push_back(voxel); });
  return voxels;
}

std::uint64_t bytes_of(const firmware::Results& results, const std::string& pool) {
  for (const firmware::PoolResult& one : results.pools) {
    if (one.name == pool) return one.bytes;
  }
  return 0;
}

}  // namespace

TEST_CASE("a profile chooses what makes a segment, and what it does not need has no memory") {
  const TempFolder folder;
  std::string last;
  for (const char* policy : {"off", "euclidean", "smoothness"}) {
    INFO(policy);
    const std::string log = folder.file(std::string(policy) + ".lcm");
    const auto run =
        run_map("ugv_hall", 1.5, log,
                hall_with({std::string("map.segments=\"") + policy + "\"", "map.min_voxels=20"}));
    CHECK(run.results.digest != last);
    last = run.results.digest;
    if (rt::posix::kHeapTrapAvailable) CHECK(run.results.counters.at("heap_calls") == 0);
    const bool smooth = std::string(policy) == "smoothness";
    CHECK((bytes_of(run.results, "normals") > 0) == smooth);
    CHECK((bytes_of(run.results, "fragments") > 0) == (std::string(policy) != "off"));
    firmware::ReplayOptions threaded;
    threaded.threaded = true;
    const firmware::ReplayOutcome parallel = replay_log(log, threaded);
    CHECK(complaint_of(parallel).empty());
    CHECK(parallel.results.digest == run.results.digest);
    const firmware::ReplayOutcome again = replay_log(log);
    CHECK(again.results.digest == run.results.digest);
    std::size_t in_segments = 0;
    std::size_t with_normal = 0;
    for (const firmware::VoxelOnMap& voxel : voxels_of(again)) {
      in_segments += voxel.segment != 0 ? 1u : 0u;
      with_normal += voxel.normal_world[0] != 0 || voxel.normal_world[1] != 0 || voxel.normal_world[2] != 0;
    }
    CHECK((in_segments > 100) == (std::string(policy) != "off"));
    CHECK((with_normal > 100) == smooth);
  }
}

TEST_CASE("with a budget segments wait, the backlog shows it, and a replay stops at the same unit") {
  const TempFolder folder;
  const std::string log = folder.file("anytime.lcm");
  // Each scan has up to 1,024 returns, a unit each.
  const auto run = run_map("ugv_hall", 2, log,
                           hall_with({"map.anytime=true", "tasks.map.units=2048", "map.min_voxels=20"}));
  const auto whole = run_map("ugv_hall", 2, folder.file("whole.lcm"), hall_with({"map.min_voxels=20"}));
  CHECK(run.results.counters.at("segment_backlog") > 0);
  CHECK(whole.results.counters.at("segment_backlog") == 0);
  CHECK(run.results.counters.at("points_used") == whole.results.counters.at("points_used"));
  firmware::ReplayOptions options;
  bool beyond = false;
  options.on_job = [&beyond](const rt::JobRecord& record, firmware::Runtime& runtime) {
    const rt::Group& group = runtime.executive().group(record.group);
    if (std::string(group.spec.name) != "mapping") return;
    for (std::uint32_t i = 0; i < group.tasks.size(); ++i)
      beyond = beyond || (std::string(group.tasks[i]->name()) == "map" && record.units[i] > 2048);
  };
  const firmware::ReplayOutcome again = replay_log(log, options);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  CHECK_FALSE(beyond);
  firmware::ReplayOptions threaded;
  threaded.threaded = true;
  CHECK(replay_log(log, threaded).results.digest == run.results.digest);
}

TEST_CASE("a map with normals goes on from a keyframe as from its start") {
  const TempFolder folder;
  const std::string log = folder.file("smooth.lcm");
  const auto run = run_map("ugv_hall", 1.5, log,
                           hall_with({"map.segments=\"smoothness\"", "map.min_voxels=20", "map.radius_m=6"}));
  const Indexed full = replay_and_keep(log, firmware::own_vehicles(), {}, 250, firmware::keyframe_path(log));
  CHECK(complaint_of(full.outcome).empty());
  firmware::ReplayOptions options;
  options.from = "@1000";
  const firmware::ReplayOutcome part = replay_log(log, options);
  CHECK(part.restored_tick == 1000);
  CHECK_FALSE(part.divergence);
  CHECK(part.results.digest == run.results.digest);
}

TEST_CASE("lists of segments tell every birth and end, and features are those of the voxels") {
  const TempFolder folder;
  const std::string log = folder.file("lists.lcm");
  static_cast<void>(run_map("ugv_hall", 1.5, log,
                            hall_with({"map.min_voxels=20", "map.radius_m=6", "map.publish=\"features\""})));
  firmware::ReplayOptions options;
  std::set<std::uint32_t> living;
  std::uint64_t lists = 0;
  std::uint64_t wrong = 0;
  const auto list = std::make_unique<rt::SegmentList>();
  rt::Tick away_until = 0;
  options.on_job = [&](const rt::JobRecord& record, firmware::Runtime& runtime) {
    if (record.tick > 100 && record.tick < away_until) return;
    auto& queue = *runtime.parts().find<firmware::ReportQueue<rt::SegmentList>>();
    for (; const rt::SegmentList* const told = queue.front(); queue.pop()) {
      *list = *told;
      ++lists;
      wrong += list->events == list->listed_events ? 0u : 1u;
      for (const rt::SegmentEvent& event : std::span(list->event, list->listed_events)) {
        const bool born = event.change == rt::SegmentChange::born;
        const bool fits = born ? living.insert(event.id).second : living.erase(event.id) == 1;
        wrong += fits ? 0u : 1u;
      }
      std::set<std::uint32_t> listed;
      for (const rt::ListedSegment& segment : std::span(list->segment, list->listed))
        listed.insert(segment.id);
      wrong += listed == living ? 0u : 1u;
    }
  };
  // A reader that stays away: what the full queue did not take, the next list tells.
  away_until = 1200;
  const firmware::ReplayOutcome slow = replay_log(log, options);
  CHECK(slow.results.counters.at("segments_overrun") > 2);
  CHECK(wrong == 0);
  CHECK(lists > 4);
  away_until = 0;
  living.clear();
  lists = 0;
  const firmware::ReplayOutcome again = replay_log(log, options);
  CHECK(complaint_of(again).empty());
  CHECK(wrong == 0);
  CHECK(again.results.counters.at("segments_overrun") == 0);
  CHECK(lists > 8);
  REQUIRE(list->listed > 1);
  CHECK(list->segments == list->listed);
  const std::vector<firmware::VoxelOnMap> voxels = voxels_of(again);
  for (const rt::ListedSegment& segment : std::span(list->segment, list->listed)) {
    INFO("segment " << segment.id);
    double sum[3]{};
    std::uint32_t count = 0;
    for (const firmware::VoxelOnMap& voxel : voxels) {
      if (voxel.segment != segment.id) continue;
      ++count;
      for (int i = 0; i < 3; ++i) sum[i] += voxel.p_world_m[i];
    }
    REQUIRE(count == segment.voxels);
    for (int i = 0; i < 3; ++i) {
      CHECK(list->origin_m[i] + static_cast<double>(segment.centroid_m[i]) ==
            Approx(sum[i] / count).margin(1e-3));
      CHECK(segment.least_m[i] <= segment.centroid_m[i]);
      CHECK(segment.centroid_m[i] <= segment.most_m[i]);
    }
    CHECK(segment.feature[0] + segment.feature[1] + segment.feature[2] == Approx(1.0).margin(1e-5));
  }
  // Without features no sums are held, and a map that publishes nothing has no list.
  const auto bytes_with = [](const char* publish) {
    const auto run =
        run_map("ugv_hall", 0.2, "", hall_with({std::string("map.publish=\"") + publish + "\""}));
    std::uint64_t bytes = 0;
    for (const firmware::PoolResult& pool : run.runtime->memory_plan()) {
      if (pool.name == "segment sums") bytes += pool.bytes;
    }
    return bytes;
  };
  CHECK(bytes_with("features") > 0);
  CHECK(bytes_with("segments") == 0);
}

namespace {

// Width that 90 % of the west wall's voxels of the hall take, after 2.5 s of turning on the spot. Its face is
// at x = -3; ranges are exact, so that only placing counts.
double wall_after_a_turn(std::vector<std::string> overrides) {
  const TempFolder folder;
  const std::string scene = folder.file("turning.toml");
  std::ofstream(scene) << "[scene]\nname = \"turning\"\nbase = \"ugv_hall\"\nabout = \"turns on the spot\"\n"
                          "[map]\nvoxel_m = 0.05\n[drive]\nmax_turn_rate_rad_s = 0.6\n[hil]\n"
                          "lidar_sigma_m = 0.0\n[[mission.commands]]\nat_s = 0.5\nturn_rad_s = 0.5\n"
                          "[[mission.commands]]\nat_s = 4.9\n";
  const std::string log = folder.file("turning.lcm");
  const auto run = run_map(scene, 4.5, log, std::move(overrides));
  CHECK(run.results.counters.at("points_unplaced") == 0);
  const double* q = run.truth.back().q;
  CHECK(std::fabs(q[3]) > 0.4);  // it did turn, by 55 degrees
  std::vector<double> x_m;
  for (const firmware::VoxelOnMap& voxel : voxels_of(replay_log(log))) {
    const double* p = voxel.p_world_m;
    if (p[0] > -3.3 && p[0] < -2.7 && std::fabs(p[1]) < 3 && p[2] > 0.3 && p[2] < 1.6) x_m.push_back(p[0]);
  }
  REQUIRE(x_m.size() > 500);
  std::sort(x_m.begin(), x_m.end());
  return x_m[x_m.size() * 19 / 20] - x_m[x_m.size() / 20];
}

}  // namespace

TEST_CASE("walls are at most 2 cm thick after sweeps that turned at 0.5 rad/s, with the right stamps alone",
          "[heavy]") {
  CHECK(wall_after_a_turn({}) <= 0.02);
  // A clock that is off by half a sweep is seen at once.
  CHECK(wall_after_a_turn({"lidar.time_offset_ms=50"}) > 0.06);
}

TEST_CASE("settings of the map that cannot be are errors that name them") {
  const auto complaint = [](std::vector<std::string> overrides) {
    return message_of<std::runtime_error>([&] { run_map("ugv_hall", 0.1, "", std::move(overrides)); });
  };
  CHECK(mentions(complaint({"map.segments=\"watershed\""}), "map.segments"));
  CHECK(mentions(complaint({"map.growing_radius_m=0.5"}), "map.growing_radius_m"));
  CHECK(
      mentions(complaint({"map.segments=\"smoothness\"", "map.normal_radius_m=0.5"}), "map.normal_radius_m"));
  CHECK(mentions(complaint({"map.radius_m=0.2"}), "map.radius_m"));
  CHECK(mentions(complaint({"limits.voxels=1000000"}), "limits.voxels"));
  CHECK(mentions(complaint({"outline.body_m=[1,0,0,0,1,1]"}), "outline.body_m"));
}

}  // namespace sortie::testing
