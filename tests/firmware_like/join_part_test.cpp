// SPDX-License-Identifier: BSD-3-Clause
// A vehicle that seeks its place on another robot's cloud: what it does meanwhile, replays, and what is
// refused.
#include <catch2/catch.hpp>

#include "tests/firmware_like/depot_rig.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"

namespace sortie::testing {
namespace {

std::uint64_t count_of(const firmware::LiveRunOutcome& run, const char* name) {
  return run.results.counters.at(name);
}

/// A small camera, clouds of few views, and work in small pieces: a match is under way in most jobs.
std::vector<std::string> in_a_hurry() {
  return displaced({"hil.camera_columns=64", "hil.camera_rows=46", "cloud.min_points=12", "join.views=4",
                    "join.units=200000"});
}

std::string fault_of_map(const std::string& map, const std::vector<std::string>& overrides,
                         const std::string& scene = "uav_depot") {
  firmware::LiveRunOptions options = depot_options(0.1, overrides);
  options.scene = scene;
  options.maps.map = map;
  return message_of<std::runtime_error>([&] { static_cast<void>(run_depot(options)); });
}

}  // namespace

TEST_CASE("A vehicle that seeks its place flies straight up and down, and not to its goals") {
  const TempFolder folder;
  const std::string map = folder.file("depot.cloud");
  const std::string log = folder.file("seeks.lcm");
  static_cast<void>(keep_cloud(3, map));
  firmware::LiveRunOptions options = depot_options(10, in_a_hurry());
  options.maps.map = map;
  options.record = log;
  options.record_fields = true;
  const firmware::LiveRunOutcome run = run_depot(options);
  CHECK(run.failures.empty());
  CHECK(count_of(run, "join_matches") > 0);
  CHECK(count_of(run, "join_placed") == 0);  // it has seen too little
  CHECK(count_of(run, "goals_reached") == 0);
  CHECK(count_of(run, "bench_collisions") == 0);
  if (rt::posix::kHeapTrapAvailable) CHECK(count_of(run, "heap_calls") == 0);
  double farthest_m = 0.0, highest_m = 0.0;
  const auto& first = run.truth.front();
  for (const auto& truth : run.truth) {
    farthest_m = std::max(farthest_m, std::hypot(truth.p[0] - first.p[0], truth.p[1] - first.p[1]));
    highest_m = std::max(highest_m, truth.p[2]);
  }
  CHECK(farthest_m < 0.1);
  CHECK(highest_m > 1.0);

  // Taken up anywhere, in the middle of a match as well, it ends in the same state.
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, {})); }),
                 "begins with the map depot.cloud"));
  firmware::ReplayOptions again;
  again.maps.map = map;
  const Indexed indexed =
      replay_and_keep(log, firmware::own_vehicles(), again, 700, firmware::keyframe_path(log));
  CHECK(indexed.outcome.results.digest == run.results.digest);
  for (const char* from : {"4.3", "7.1", "9.2"}) {
    INFO("from " << from);
    firmware::ReplayOptions part = again;
    part.from = from;
    CHECK(replay_log(log, part).results.digest == run.results.digest);
  }
}

TEST_CASE("Without a kept cloud the own frame is the mission's, and nothing is sought") {
  const firmware::LiveRunOutcome run =
      run_depot(depot_options(8, {"hil.camera_columns=16", "hil.camera_rows=12"}));
  CHECK(run.failures.empty());
  CHECK(count_of(run, "join_matches") == 0);
  CHECK(count_of(run, "cloud_views") > 0);
  double farthest_m = 0.0;
  for (const auto& truth : run.truth)
    farthest_m = std::max(farthest_m, std::hypot(truth.p[0] - 13.4, truth.p[1] - 2.0));
  CHECK(farthest_m > 1.0);  // under way
}

TEST_CASE("A cloud or a scene that does not do is refused with the cure") {
  const TempFolder folder;
  const std::string map = folder.file("depot.cloud");
  std::vector<std::uint8_t> bytes = keep_cloud(1, map);
  CHECK(mentions(fault_of_map(map, {}), "flight_map.source"));
  CHECK(mentions(fault_of_map(map, {}), "sortie export flight_map"));
  auto without_looks = in_a_hurry();
  without_looks.emplace_back("mission.looks=[]");
  CHECK(mentions(fault_of_map(map, without_looks), "mission.looks"));
  CHECK(mentions(fault_of_map(map, {}, "uav_rescue"), "tasks.join.enabled=true"));
  bytes[bytes.size() / 2] ^= 1u;
  const std::string damaged = folder.file("damaged.cloud");
  std::ofstream(damaged, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  CHECK(mentions(fault_of_map(damaged, in_a_hurry()), "sortie export cloud"));
  CHECK(mentions(fault_of_map(folder.file("none"), {}), "sortie export cloud"));
  const std::string two_readers = message_of<firmware::ProfileError>([] {
    const firmware::Runtime runtime(firmware::load_scene("uav_room_sensed", {"tasks.cloud.enabled=true"}),
                                    firmware::own_vehicles(), {});
  });
  CHECK(mentions(two_readers, "flight_map.source"));
}

TEST_CASE("A vehicle that nobody can place lands where it is", "[heavy]") {
  const TempFolder folder;
  const std::string map = folder.file("depot.cloud");
  static_cast<void>(keep_cloud(3, map));
  auto keys = in_a_hurry();
  keys.emplace_back("mission.look_rounds=1");
  firmware::LiveRunOptions options = depot_options(60, keys);
  options.maps.map = map;
  const firmware::LiveRunOutcome run = run_depot(options);
  CHECK(count_of(run, "join_placed") == 0);
  CHECK(count_of(run, "goals_reached") == 0);
  CHECK(count_of(run, "bench_landed") == 1);
  CHECK(std::hypot(run.truth.back().p[0] - run.truth.front().p[0],
                   run.truth.back().p[1] - run.truth.front().p[1]) < 0.3);
}

TEST_CASE("A vehicle finds its place on a ground robot's cloud from another frame, and flies by its map",
          "[heavy]") {
  const TempFolder folder;
  const std::string map = folder.file("depot.cloud");
  keep_ground_cloud(map);
  CHECK(flies_by_cloud(map, 13));  // two of its neighbours are refused: join_flights_long_test.cpp
}

}  // namespace sortie::testing
