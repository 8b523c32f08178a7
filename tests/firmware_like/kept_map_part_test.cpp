// SPDX-License-Identifier: BSD-3-Clause
// Runs that begin with the map of another one: told where they are, told nothing, and maps that do not fit.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "tests/firmware_like/kept_map_rig.hpp"

namespace sortie::testing {
namespace {

std::string refusal_of(const std::string& log, const firmware::ReplayOptions& options) {
  return message_of<firmware::ProfileError>([&] { static_cast<void>(replay_log(log, options)); });
}

}  // namespace

TEST_CASE("a run begins with the map of another, and its log replays with that map alone", "[heavy]") {
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
    options.maps.map = other;
    CHECK(mentions(refusal_of(log, options), "begins with the map hall.surfels (digest "));
    CHECK(mentions(refusal_of(log, options), "is another one"));
    options.maps.map = map;
    const firmware::ReplayOutcome again = replay_log(log, options);
    CHECK(complaint_of(again).empty());
    CHECK(again.comparable);
    CHECK(again.results.digest == run.results.digest);
    CHECK(map_bytes(*again.runtime) == map_bytes(*run.runtime));
  }
}

TEST_CASE("a robot that is told nothing finds its place on the map of another run, and replays to the bit",
          "[heavy]") {
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
  options.maps.map = map;
  const firmware::ReplayOutcome again = replay_log(log, options);
  CHECK(complaint_of(again).empty());
  CHECK(again.results.digest == run.results.digest);
  // Two looks so near each other are not enough where one of them is not sure.
  for (const char* const far_look : {"relocate.far_look_m=6", "relocate.far_look_m=0.2"}) {
    INFO(far_look);
    std::vector<std::string> unsure = wanted;
    unsure.insert(unsure.end(), {"relocate.surely_over_unexplained=100", far_look});
    const firmware::LiveRunOutcome looked = run_located(9, "", unsure, map);
    CHECK(counted(looked, "relocate_placed") >= 2);
    CHECK(counted(looked, "relocate_first_looks") == 1);
    CHECK((counted(looked, "locate_accepted") > 0) == (far_look == std::string("relocate.far_look_m=0.2")));
  }
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
  CHECK(mentions(
      why({on, "tasks.relocate.enabled=true", "tasks.relocate.budget_us=10000", "limits.tops=1"}, map),
      "cure: --set limits.tops="));
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

}  // namespace sortie::testing
