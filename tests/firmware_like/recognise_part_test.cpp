// SPDX-License-Identifier: BSD-3-Clause
// A robot comes back to a hall that another run has seen, from the other side: what it recognises, and where
// that places it.
#include <catch2/catch.hpp>
#include <fstream>

#include "mapping/recognition/target_file.hpp"
#include "tests/firmware_like/kept_map_rig.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"

namespace sortie::testing {
namespace {

const std::vector<std::string> kRecognising = {"map.segments=smoothness",   "tasks.recognise.enabled=true",
                                               "tasks.locate.enabled=true", "hil.lidar_rows=16",
                                               "hil.lidar_columns=180",     "limits.voxels=65536",
                                               "tasks.map.budget_us=20000"};

firmware::LiveRunOutcome run_recognising(double seconds, const std::string& log,
                                         const firmware::KeptMapPaths& maps,
                                         const std::vector<std::string>& more) {
  watch_heap();
  firmware::LiveRunOptions options;
  options.scene = "ugv_hall";
  options.overrides = kRecognising;
  options.overrides.insert(options.overrides.end(), more.begin(), more.end());
  options.seconds = seconds;
  options.virtual_time = true;
  options.record = log;
  options.maps = maps;
  options.lcm_url = "none";
  firmware::LiveRunOutcome run =
      firmware::run_live(firmware::own_vehicles(), toolchain::make_simulated_robot, options);
  static_cast<void>(toolchain::judge(run));
  return run;
}

std::vector<std::uint8_t> target_bytes(const firmware::Runtime& runtime) {
  const mapping::TargetStore* targets = runtime.vehicle().targets();
  REQUIRE(targets != nullptr);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::target_file_bytes(*targets)));
  REQUIRE(mapping::write_targets(*targets, bytes) == Status::ok);
  return bytes;
}

void write(const std::string& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

TEST_CASE("A lost robot recognises a hall that it drives through the other way round, and replays to the bit",
          "[heavy]") {
  const TempFolder folder;
  const firmware::KeptMapPaths seen{folder.file("hall.surfels"), folder.file("hall.targets")};
  const std::string first_log = folder.file("first.lcm"), log = folder.file("again.lcm");
  const firmware::LiveRunOutcome first = run_recognising(60, first_log, {}, {});
  CHECK(first.failures.empty());
  CHECK(counted(first, "recognise_targets_added") > 20);
  CHECK(counted(first, "recognise_searches_begun") == 0);  // nothing is known
  const std::vector<std::uint8_t> bytes = target_bytes(*first.runtime);
  CHECK((target_bytes(*replay_log(first_log, {}).runtime) == bytes));
  write(seen.targets, bytes);
  write(seen.map, map_bytes(*first.runtime));

  const std::vector<std::string> round = {
      "locate.window_cells=256",
      "mission.waypoints=[[0.0,-4.0],[9.3,-4.0],[14.0,-4.0],[14.0,4.0],[9.3,4.0],[9.3,0.0],[0.0,0.0]]"};
  const firmware::LiveRunOutcome run = run_recognising(40, log, seen, round);
  CHECK(run.failures.empty());
  CHECK(counted(run, "recognise_recognised") >= 3);
  CHECK(counted(run, "recognise_refused") == 0);
  CHECK(counted(run, "locate_unplaced_on_map") > 20);
  CHECK(counted(run, "locate_accepted") > 100);
  CHECK(error_of(run.results, "located_ate_max_m") < 0.15);
  if (rt::posix::kHeapTrapAvailable) CHECK(counted(run, "heap_calls") == 0);

  firmware::ReplayOptions options;
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); }),
                 "begins with the map hall.surfels"));
  options.maps.map = seen.map;
  CHECK(mentions(message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); }),
                 "begins with the targets hall.targets"));
  options.maps = seen;
  const Indexed indexed =
      replay_and_keep(log, firmware::own_vehicles(), options, 4000, firmware::keyframe_path(log));
  CHECK(indexed.outcome.results.digest == run.results.digest);
  for (const char* const from : {"5.05", "11.35", "23.55"}) {
    INFO("from " << from);
    options.from = from;
    const firmware::ReplayOutcome part = replay_log(log, options);
    CHECK(complaint_of(part).empty());
    CHECK(part.results.digest == run.results.digest);
  }
}

TEST_CASE("targets that cannot be used are refused with their cure") {
  const TempFolder folder;
  const std::string nothing = folder.file("nothing.targets"), text = folder.file("text.targets"),
                    cut = folder.file("cut.targets");
  write(text, std::vector<std::uint8_t>(40, 'x'));
  std::vector<std::byte> memory(1 << 20);
  rt::Arena arena(memory);
  mapping::TargetStore store({}, arena);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(mapping::target_file_bytes(store)));
  REQUIRE(mapping::write_targets(store, bytes) == Status::ok);
  bytes.pop_back();
  write(cut, bytes);
  const auto refused = [&](const firmware::KeptMapPaths& maps, const std::vector<std::string>& more) {
    return message_of<std::runtime_error>([&] { static_cast<void>(run_recognising(1, "", maps, more)); });
  };
  CHECK(mentions(refused({"", nothing}, {}),
                 "cannot be read; make it with `sortie export targets LOG -o FILE`"));
  CHECK(mentions(refused({"", text}, {}), "holds no targets"));
  CHECK(mentions(refused({cut, ""}, {}), "give it with --targets"));
  CHECK(mentions(refused({"", cut}, {}), "cut off, or too long"));
  CHECK(mentions(refused({"", cut}, {"tasks.recognise.enabled=false"}), "tasks.recognise.enabled=true"));
  CHECK(mentions(refused({}, {"map.segments=off"}), "map.segments=euclidean"));
}

}  // namespace sortie::testing
