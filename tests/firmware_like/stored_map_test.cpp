// SPDX-License-Identifier: BSD-3-Clause
// A map that one robot made and another one flies by: as text, gathered from a window that moves, and in
// closed loop.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <map>
#include <random>
#include <tuple>

#include "firmware_like/scene/input_error.hpp"
#include "mapping/occupancy/occupancy.hpp"
#include "tests/firmware_like/keyframes_rig.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "toolchain/export/flight_map.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using namespace sortie::testing;

namespace {

std::string unpack_fault(const std::string& text, std::size_t count) {
  try {
    static_cast<void>(unpack_cells(text, count));
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

// A room of 6 m x 4 m x 2.4 m at 0.2 m: all free but the voxels for which `is_blocked` holds.
template <class F>
std::string room_cells(F is_blocked) {
  std::vector<CellState> cells;
  for (int z = 0; z < 12; ++z) {
    for (int y = 0; y < 20; ++y) {
      for (int x = 0; x < 32; ++x)
        cells.push_back(is_blocked(x, y, z) ? CellState::blocked : CellState::free);
    }
  }
  return pack_cells(cells);
}

LiveRunOutcome fly_stored(const std::string& cells, const std::string& record = "") {
  LiveRunOptions options;
  options.scene = "uav_neo11";
  options.overrides = {"tasks.path.enabled=true",
                       "flight_map.x_m=-1.0",
                       "flight_map.y_m=-2.0",
                       "flight_map.length_m=6.4",
                       "flight_map.width_m=4.0",
                       "flight_map.height_m=2.4",
                       "flight_map.source=\"stored\"",
                       "flight_map.cells=\"" + cells + "\"",
                       "mission.goals=[{x_m=4.0,y_m=0.0,z_m=1.2,wait_s=0.5}]"};
  options.seconds = 14;
  options.virtual_time = true;
  options.lcm_url = "none";
  options.record = record;
  options.record_fields = !record.empty();
  return run_live(own_vehicles(), make_simulated_robot, options);
}

}  // namespace

TEST_CASE("Cells come back from their text, and no text of the same cells is shorter") {
  const std::uint64_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  bool same = true;
  bool shortest = true;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<CellState> cells(static_cast<std::size_t>(random() % 3000));
    CellState state = CellState::unknown;
    std::size_t runs = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (random() % 8 == 0) state = static_cast<CellState>(random() % 3);
      cells[i] = state;
      runs += i == 0 || cells[i] != cells[i - 1] ? 1 : 0;
    }
    const std::string text = pack_cells(cells);
    same = same && unpack_cells(text, cells.size()) == cells;
    std::size_t letters = 0;
    for (const char c : text) letters += c == 'u' || c == 'f' || c == 'b' ? 1 : 0;
    shortest = shortest && letters == runs;
  }
  CHECK(same);
  CHECK(shortest);
  CHECK(pack_cells(std::vector<CellState>(12, CellState::free)) == "f12");
}

TEST_CASE("A text that is no map is refused with its place, whatever it asks for") {
  CHECK(unpack_fault("f3b1", 4).empty());
  CHECK_THAT(unpack_fault("f3x1", 4), Catch::Contains("character 3") && Catch::Contains("u, f or b"));
  CHECK_THAT(unpack_fault("f3b", 4), Catch::Contains("character 4") && Catch::Contains("number of cells"));
  CHECK_THAT(unpack_fault("f0b4", 4), Catch::Contains("character 2"));
  CHECK_THAT(unpack_fault("f-1", 4), Catch::Contains("character 2"));
  CHECK_THAT(unpack_fault("f3", 4), Catch::Contains("ends after 3 of the map's 4"));
  CHECK_THAT(unpack_fault("f5", 4), Catch::Contains("more cells than the map's 4"));
  CHECK_THAT(unpack_fault("f99999999999999999999", 4), Catch::Contains("character 2"));
  CHECK_THAT(unpack_fault("f18446744073709551615b2", 4), Catch::Contains("more cells"));
}

TEST_CASE("What a rolling window has shown of a flight map is gathered, and nothing of it is lost") {
  const std::uint64_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  mapping::OccupancyConfig size;
  size.size[0] = 24;
  size.size[1] = 16;
  size.size[2] = 8;
  size.roll_cells = 4;
  std::vector<std::int8_t> memory(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(size)));
  mapping::OccupancyMap map(size, memory);
  Profile profile(
      "[scene]\nname = \"m\"\nvehicle = \"uav\"\n[flight_map]\nx_m = -1.07\ny_m = -1.0\nlength_m = 8\n"
      "width_m = 3.2\nheight_m = 1.6\n",
      "m.toml");
  const GuideConfig config = read_flight_voxels(profile);
  FlightMapGatherer gatherer(config);
  // The twin: the newest word on each cell of the world.
  std::map<std::tuple<int, int, int>, int> newest;
  for (int step = 0; step < 40; ++step) {
    // There and back: what left the window comes in again unknown.
    const double x_m = 0.5 * (step < 20 ? step : 40 - step) - 2.0;
    REQUIRE(map.centre_on({x_m, 0.02 * step, 0.5}) == Status::ok);
    for (int i = 0; i < 800; ++i) {
      const auto draw = [&random](std::int32_t n) {
        return static_cast<std::int32_t>(random() % std::uint64_t(n));
      };
      map.set(draw(size.size[0]), draw(size.size[1]), draw(size.size[2]),
              static_cast<int>(random() % 120) - 60);
    }
    gatherer.take(map.view());
    const mapping::OccupancyView view = map.view();
    const std::int8_t* cell = view.cells;
    for (int z = 0; z < view.size[2]; ++z) {
      for (int y = 0; y < view.size[1]; ++y) {
        for (int x = 0; x < view.size[0]; ++x, ++cell) {
          if (*cell == mapping::kUnknownCell) continue;
          int& word =
              newest.try_emplace({x + view.low[0], y + view.low[1], z + view.low[2]}, 0).first->second;
          if (*cell > config.cells.blocked_code) word = 2;
          if (*cell <= config.cells.free_code) word = 1;
        }
      }
    }
  }
  std::size_t compared = 0;
  std::size_t wrong = 0;
  std::size_t index = 0;
  for (int z = 0; z < config.map.nz; ++z) {
    for (int y = 0; y < config.map.ny; ++y) {
      for (int x = 0; x < config.map.nx; ++x) {
        // Number of the voxel in the world, from its middle: (m - 0.1) / 0.2 is whole.
        const rt::Vector3 m = config.map.origin_m + 0.2 * rt::Vector3{x + 0.5, y + 0.5, z + 0.5};
        const auto whole = [](double value) { return static_cast<int>(std::lround(value / 0.2 - 0.5)); };
        const auto word = newest.find({whole(m.x), whole(m.y), whole(m.z)});
        const int expected = word == newest.end() ? 0 : word->second;
        wrong += static_cast<int>(gatherer.cells()[index++]) != expected ? 1 : 0;
        compared += expected != 0 ? 1 : 0;
      }
    }
  }
  CHECK(wrong == 0);
  // The draw decides how many (some 2,030), the check only that they are not few.
  CHECK(compared > 1000);
  CHECK(gatherer.count(CellState::free) + gatherer.count(CellState::blocked) == compared);
  mapping::OccupancyView other = map.view();
  other.voxel_size_m = 0.1;
  CHECK_THROWS_AS(gatherer.take(other), InputError);
}

TEST_CASE(
    "A stored map is flown by: around what is blocked, not through what is unknown, the same in a replay") {
  const TempFolder folder;
  const std::string log = folder.file("stored.lcm");
  // A wall across, open for 1.6 m on the left, that the simulated world does not have.
  const std::string walled = room_cells([](int x, int y, int) { return x == 14 && y < 12; });
  const LiveRunOutcome around = fly_stored(walled, log);
  CHECK(around.results.counters.at("goals_reached") == 1);
  double least_y_m = 1e9;  // where it passed the wall's plane
  for (const auto& truth : around.truth) {
    if (std::fabs(truth.p[0] - 1.9) < 0.1) least_y_m = std::fmin(least_y_m, truth.p[1]);
  }
  CHECK(least_y_m > 0.4 + 0.45);  // the opening's edge and the vehicle's own radius
  const Indexed indexed = replay_and_keep(log, own_vehicles(), {}, 250, keyframe_path(log));
  CHECK(indexed.outcome.results.digest == around.results.digest);
  ReplayOptions part;
  part.from = "6.0";
  CHECK(replay_log(log, part).results.digest == around.results.digest);

  const std::string shut = room_cells([](int x, int, int) { return x == 14; });
  CHECK(fly_stored(shut).results.counters.at("goals_reached") == 0);
  CHECK(fly_stored(shut).results.counters.at("goals_without_way") >= 1);
  std::string veiled = shut;  // the same wall, only not known to be one
  for (char& c : veiled) c = c == 'b' ? 'u' : c;
  CHECK(fly_stored(veiled).results.counters.at("goals_reached") == 0);
}

TEST_CASE("A stored map that is not there, or of another size, is refused with the cure") {
  const auto problem = [](const std::vector<std::string>& overrides) {
    try {
      const Runtime runtime(load_scene("uav_rescue", overrides), own_vehicles(), RuntimeStart{});
    } catch (const ProfileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK_THAT(problem({"flight_map.source=\"stored\""}), Catch::Contains("sortie export flight_map"));
  CHECK_THAT(problem({"flight_map.source=\"stored\"", "flight_map.cells=\"f12\""}),
             Catch::Contains("flight_map.cells") && Catch::Contains("another size"));
  CHECK_THAT(problem({"flight_map.cells=\"f12\""}), Catch::Contains("flight_map.cells"));
}
