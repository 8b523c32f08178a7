// SPDX-License-Identifier: BSD-3-Clause
// Sweeps of a tiny log from end to end, and the agreement of their maps against brute force.
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <random>
#include <set>
#include <sstream>
#include <tuple>

#include "firmware_like/scene/json.hpp"
#include "tests/firmware_like/run_support.hpp"
#include "tests/firmware_like/xml_check.hpp"
#include "toolchain/judge/map_volume.hpp"
#include "toolchain/program/program.hpp"
#include "toolchain/sweep/sweep_report.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using Catch::Matchers::Contains;

namespace {

using Cell = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

// The cell numbers as map_volume packs them.
MapVolume volume_of(double voxel_m, const std::set<Cell>& cells) {
  MapVolume volume;
  volume.voxel_m = voxel_m;
  for (const auto& [x, y, z] : cells) {
    constexpr std::int64_t kHalf = 1 << 20;
    volume.cells.push_back(static_cast<std::uint64_t>(x + kHalf) << 42 |
                           static_cast<std::uint64_t>(y + kHalf) << 21 |
                           static_cast<std::uint64_t>(z + kHalf));
  }
  return volume;
}

}  // namespace

TEST_CASE("Two maps agree by the volume that counting small cubes finds") {
  const unsigned seed = 7;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  const auto draw = [&random](std::int64_t half) {
    return static_cast<std::int64_t>(random() % static_cast<unsigned>(2 * half)) - half;
  };
  for (const std::int64_t ratio : {1, 2, 3}) {
    std::set<Cell> fine;
    std::set<Cell> coarse;
    for (int i = 0; i < 300; ++i) {
      const std::int64_t x = draw(6);
      const std::int64_t y = draw(6);
      fine.emplace(x, y, draw(6));
    }
    for (int i = 0; i < 60 / ratio; ++i) {
      const std::int64_t x = draw(6 / ratio);
      const std::int64_t y = draw(6 / ratio);
      coarse.emplace(x, y, draw(6 / ratio));
    }
    double common = 0;
    double either = 0;
    for (std::int64_t x = -6; x < 6; ++x)
      for (std::int64_t y = -6; y < 6; ++y)
        for (std::int64_t z = -6; z < 6; ++z) {
          const auto down = [ratio](std::int64_t v) { return (v + 60 * ratio) / ratio - 60; };
          const bool in_fine = fine.count({x, y, z}) != 0;
          const bool in_coarse = coarse.count({down(x), down(y), down(z)}) != 0;
          common += in_fine && in_coarse ? 1 : 0;
          either += in_fine || in_coarse ? 1 : 0;
        }
    const MapAgreement agreement =
        compare_volumes(volume_of(0.1 * static_cast<double>(ratio), coarse), volume_of(0.1, fine));
    INFO("ratio " << ratio);
    const auto n = static_cast<double>(fine.size());
    CHECK(agreement.disagreement == Approx(1 - common / either));
    CHECK(agreement.missed == Approx(1 - common / n));
    CHECK(agreement.excess == Approx((either - n) / n));
    CHECK(compare_volumes(volume_of(0.1, fine), volume_of(0.1, fine)).disagreement ==
          Approx(0).margin(1e-12));
  }
}

namespace {

Sweep sweep_hall(const std::string& log, const std::vector<std::string>& knobs, std::uint32_t repeat = 1,
                 const std::string& error = "") {
  SweepOptions options;
  options.knobs = parse_knobs(knobs);
  options.repeat = repeat;
  options.error = error;
  return run_sweep(LogFile(log), own_vehicles(), options);
}

}  // namespace

TEST_CASE("A sweep of a tiny log replays every cell and marks the profile's choice") {
  const testing::TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  testing::run_hall(3, log);
  std::vector<double> shares;
  SweepOptions options;
  options.knobs = parse_knobs({"map.voxel_m=0.2,0.1", "map.max_range_m=5,25"});
  options.repeat = 2;
  options.progress = [&shares](double share) { shares.push_back(share); };
  const Sweep sweep = run_sweep(LogFile(log), own_vehicles(), options);

  REQUIRE(sweep.cells.size() == 4);
  CHECK(sweep.cells[0].values == std::vector<std::string>{"0.2", "5"});
  CHECK(sweep.cells[1].values == std::vector<std::string>{"0.2", "25"});
  CHECK(sweep.cells[3].values == std::vector<std::string>{"0.1", "25"});
  for (std::size_t i = 0; i < 4; ++i) CHECK(sweep.cells[i].profile_choice == (i == 3));
  CHECK(sweep.tasks == std::vector<std::string>{"map"});
  CHECK(sweep.error == "map_disagreement");
  CHECK(sweep.cells[3].errors.at("map_disagreement") == 0);  // it is the reference
  CHECK(sweep.cells[0].errors.at("map_disagreement") > 0.5);
  CHECK(sweep.cells[0].errors.at("map_missed") > sweep.cells[1].errors.at("map_missed"));
  CHECK(sweep.cells[0].voxels < sweep.cells[1].voxels);
  CHECK(sweep.cells[1].voxels < sweep.cells[3].voxels);
  CHECK(sweep.cells[3].on_front);

  // Each cell is what a replay of its own gives.
  ReplayOptions alone;
  alone.overrides = {"map.voxel_m=0.2", "map.max_range_m=25"};
  const ReplayOutcome outcome = testing::replay_log(log, alone);
  CHECK(sweep.cells[1].digest == outcome.results.digest);
  CHECK(sweep.cells[1].memory_bytes == outcome.runtime->memory_bytes());
  const rt::Executive& executive = outcome.runtime->executive();
  const rt::TaskBase& map = executive.task(executive.task_count() - 1);
  for (const SweepCell& cell : sweep.cells) {
    REQUIRE(cell.timing.size() == 1);
    CHECK(cell.timing[0].n == 2 * map.wall_time().count());
    CHECK(cell.timing[0].p50_us <= cell.timing[0].p99_us);
    CHECK(cell.timing[0].p99_us <= cell.timing[0].max_us);
    CHECK(cell.load_us_per_s > 0);
  }
  CHECK(std::is_sorted(shares.begin(), shares.end()));
  CHECK(shares.back() == 1);
}

TEST_CASE("The profile's own choice is added where the grid does not hold it") {
  const testing::TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  testing::run_hall(1, log);
  const Sweep sweep = sweep_hall(log, {"attitude.acc_time_constant_s=0.1,9"});
  REQUIRE(sweep.cells.size() == 3);
  CHECK(sweep.cells[2].profile_choice);
  CHECK(sweep.cells[2].digest == testing::replay_log(log).results.digest);
  CHECK(sweep.tasks == std::vector<std::string>{"attitude"});
  CHECK(sweep.error == "inclination_rmse_deg");
  CHECK(sweep_hall(log, {"attitude.acc_time_constant_s=0.1"}, 1, "ate_rmse_m").error == "ate_rmse_m");
  CHECK(sweep_hall(log, {"groups.control.rate_hz=500"}).tasks ==
        std::vector<std::string>{"parameters_control", "attitude", "odometry", "drive"});
}

TEST_CASE("A sweep writes a table, CSV, JSON and a plot that hold every cell") {
  Sweep sweep;
  sweep.scene = "hall";
  sweep.keys = {"map.voxel_m", "mission.waypoints"};
  sweep.tasks = {"map", "drive"};
  sweep.error = "ate_rmse_m";
  sweep.repeat = 3;
  for (int i = 0; i < 3; ++i) {
    SweepCell cell;
    cell.values = {std::to_string(i), "[[1,2]]"};
    cell.errors = {{"ate_rmse_m", i == 2 ? std::nan("") : 1.5 - i}};
    cell.load_us_per_s = 100 + 50 * i;
    cell.on_front = i < 2;
    cell.profile_choice = i == 1;
    cell.digest = "00ff";
    cell.timing = {{"map", 30, 1, 2, 3}, {"drive", 60, 4, 5, 6}};
    sweep.cells.push_back(cell);
  }
  std::ostringstream csv;
  write_sweep_csv(csv, sweep);
  std::istringstream lines(csv.str());
  std::string line;
  std::getline(lines, line);
  CHECK(line ==
        "map.voxel_m,mission.waypoints,profile_choice,on_front,ate_rmse_m,voxels,voxels_refused,memory_bytes,"
        "load_us_per_s,map_n,map_p50_us,map_p99_us,map_max_us,drive_n,drive_p50_us,drive_p99_us,drive_max_us,"
        "digest");
  std::getline(lines, line);
  CHECK(line == "0,\"[[1,2]]\",0,1,1.5,0,0,0,100,30,1,2,3,60,4,5,6,00ff");
  std::getline(lines, line);
  std::getline(lines, line);
  CHECK(line == "2,\"[[1,2]]\",0,0,,0,0,0,200,30,1,2,3,60,4,5,6,00ff");

  const auto json = to_json(sweep);
  CHECK(json["cells"].size() == 3);
  CHECK(json["cells"][1]["values"]["map.voxel_m"] == "1");
  CHECK(json["cells"][2]["errors"]["ate_rmse_m"].is_null());
  CHECK(json["cells"][1]["profile_choice"] == true);
  CHECK(json["cells"][0]["tasks"][1]["p99_us"] == 5);

  std::ostringstream table;
  print_sweep(table, sweep);
  CHECK_THAT(table.str(), Contains("ate_rmse_m") && Contains("drive") && Contains("*<"));

  const std::string svg = render(plot_sweep(sweep));
  CHECK(testing::xml_fault(svg).empty());
  CHECK_THAT(svg, Contains(">0, [[1,2]]<") && Contains(">1, [[1,2]]<"));
}

namespace {

struct Ended {
  int code;
  std::string words;
};

// The command line with its words caught.
Ended run_command(std::vector<std::string> words) {
  words.insert(words.begin(), {"sortie", "bench"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  std::ostringstream err;
  std::ostringstream out;
  auto* const cerr_was = std::cerr.rdbuf(err.rdbuf());
  auto* const cout_was = std::cout.rdbuf(out.rdbuf());
  ProgramParts parts;
  parts.vehicles = own_vehicles();
  const int code = run_program(static_cast<int>(arguments.size()), arguments.data(), parts);
  std::cerr.rdbuf(cerr_was);
  std::cout.rdbuf(cout_was);
  return {code, err.str() + out.str()};
}

}  // namespace

TEST_CASE("The bench command ends with code 2 and a cure for what cannot be swept") {
  const testing::TempFolder folder;
  const std::string log = folder.file("hall.lcm");
  testing::run_hall(1, log);
  for (const auto& [words, said] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{log, "--sweep", "map.voxel_m"}, "write key=v1,v2,v3"},
           {{log, "--sweep", "map.voxel=0.1,0.2"}, "did you mean map.voxel_m?"},
           {{log, "--sweep", "map.voxel_m=0.1,99"}, "with map.voxel_m=99"},
           {{log, "--sweep", "groups.control.rate_hz=500,333"}, "nearest"},
           {{log, "--sweep", "map.voxel_m=0.1", "--task", "maps"}, "it has: parameters_control, attitude"},
           {{log, "--sweep", "map.voxel_m=0.1", "--error", "ate"}, "they give: "},
           {{log}, "--sweep"},
           {{log, "--sweep", "map.voxel_m=0.1", "--repeat", "0"}, "--repeat"}}) {
    const Ended ended = run_command(words);
    INFO(ended.words);
    CHECK(ended.code == 2);
    CHECK_THAT(ended.words, Contains(said));
  }
  CHECK(run_command({folder.file("none.lcm"), "--sweep", "map.voxel_m=0.1"}).code == 3);
  CHECK(run_command({"--scene", "ugv_hall", log, "--sweep", "map.voxel_m=0.1"}).code ==
        0);  // the log is no scene

  const Ended good =
      run_command({"--log", log, "--sweep", "map.voxel_m=0.2", "--json", "--out", folder.file("out")});
  INFO(good.words);
  CHECK(good.code == 0);
  const auto json = Json::parse(testing::read_all(folder.file("out/sweep.json")));
  CHECK(json["cells"].size() == 2);
  CHECK(std::filesystem::file_size(folder.file("out/sweep.csv")) > 0);
  CHECK(testing::xml_fault(testing::read_all(folder.file("out/sweep.svg"))).empty());
}
