// SPDX-License-Identifier: BSD-3-Clause
// What a sweep runs and which of its results are worth having: the syntax of a knob, the order of the grid,
// the Pareto front against brute force.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/firmware_like/run_support.hpp"
#include "toolchain/judge/pareto.hpp"
#include "toolchain/sweep/sweep.hpp"
#include "toolchain/sweep/sweep_jobs.hpp"
#include "toolchain/sweep/sweep_set.hpp"
#include "toolchain/sweep/sweep_slurm.hpp"

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;
using Catch::Matchers::Contains;

TEST_CASE("A knob is a key and its values, commas within brackets and quotes are no divider") {
  const SweepKnob plain = parse_knob("map.voxel_m=0.05, 0.1,0.2");
  CHECK(plain.key == "map.voxel_m");
  CHECK(plain.values == std::vector<std::string>{"0.05", "0.1", "0.2"});
  const SweepKnob nested = parse_knob("mission.waypoints=[[1,2],[3,4]],[[5,6]]");
  CHECK(nested.values == std::vector<std::string>{"[[1,2],[3,4]]", "[[5,6]]"});
  CHECK(parse_knob("a.b=\"x,y\",'z,='").values == std::vector<std::string>{"\"x,y\"", "'z,='"});
}

TEST_CASE("A knob that cannot be read is named together with its cure") {
  const auto text = GENERATE(as<std::string>{}, "map.voxel_m", "map.voxel_m=", "map.voxel_m=0.1,,0.2",
                             "map.voxel_m=0.1,", "=1,2", "", "map.voxel_m= , ");
  const std::string message = testing::message_of<ProfileError>([&] { parse_knob(text); });
  INFO(text << " -> " << message);
  CHECK_THAT(message, Contains("--sweep " + text));
  CHECK_THAT(message, Contains("key=v1,v2,v3"));
}

TEST_CASE("Values and keys that stand there twice are refused, and so is a grid without end") {
  CHECK_THAT(testing::message_of<ProfileError>([] { parse_knob("a.b=0.1,0.10"); }), Contains("twice"));
  CHECK_THAT(testing::message_of<ProfileError>([] {
               parse_knobs({"a.b=1,2", "a.b=3"});
             }),
             Contains("swept already"));
  CHECK_NOTHROW(parse_knobs({"a.b=1,2", "a.c=1,2"}, 4));
  CHECK_THAT(testing::message_of<ProfileError>([] {
               parse_knobs({"a.b=1,2", "a.c=1,2,3"}, 5);
             }),
             Contains("more than 5"));
}

TEST_CASE("The grid has the order of nested loops, the first knob outermost") {
  const auto grid = span_grid({{"a", {"1", "2"}}, {"b", {"x", "y", "z"}}, {"c", {"p", "q"}}});
  std::vector<std::vector<std::string>> expected;
  for (const char* a : {"1", "2"})
    for (const char* b : {"x", "y", "z"})
      for (const char* c : {"p", "q"}) expected.push_back({a, b, c});
  CHECK(grid == expected);
  CHECK(span_grid({}).size() == 1);
}

TEST_CASE("The same value is a number or a text, not its spelling") {
  CHECK(same_value("0.10", "1e-1"));
  CHECK(same_value("refuse", "\"refuse\""));
  CHECK_FALSE(same_value("0.1", "0.10001"));
  CHECK_FALSE(same_value("true", "false"));
  CHECK_FALSE(same_value("1", "1 m"));
}

TEST_CASE("The Pareto front is what brute force finds, with twins, ties and NaN") {
  const unsigned seed = 20260711;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::size_t on_front = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<CostAndError> points(random() % 40);
    for (CostAndError& point : points) {  // few values, so that twins and ties are common
      point.cost = static_cast<double>(random() % 12);
      point.error = static_cast<double>(random() % 12);
      if (random() % 15 == 0) point.error = std::nan("");
      if (random() % 15 == 0) point.cost = std::nan("");
      if (random() % 20 == 0) point.error = std::numeric_limits<double>::infinity();
    }
    const std::vector<bool> front = pareto_front(points);
    REQUIRE(front.size() == points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool expected = !std::isnan(points[i].cost) && !std::isnan(points[i].error);
      for (const CostAndError& other : points) {
        const bool as_good = other.cost <= points[i].cost && other.error <= points[i].error;
        const bool better = other.cost < points[i].cost || other.error < points[i].error;
        if (as_good && better) expected = false;
      }
      REQUIRE(front[i] == expected);
      on_front += front[i] ? 1 : 0;
    }
  }
  CHECK(on_front > 300);
}

TEST_CASE("Costs that lie closer than can be measured count as one cost") {
  std::vector<CostAndError> points{{100, 3}, {102, 1}, {104, 2}, {98, 4}, {std::nan(""), 0}, {101.5, 5}};
  merge_close(points, &CostAndError::cost, 0.05);
  const std::vector<double> expected{98, 98, 104, 98};
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(points[i].cost == expected[i]);
  CHECK(std::isnan(points[4].cost));
  CHECK(points[5].cost == 98);
  CHECK(points[0].error == 3);
  CHECK(pareto_front(points) == std::vector<bool>{false, true, false, false, false, false});
}

TEST_CASE("Each cell belongs to exactly one shard, whatever the count of both") {
  for (const std::size_t cells : {0u, 1u, 7u, 12u, 50u}) {
    for (std::size_t n = 1; n <= 9; ++n) {
      std::vector<int> owners(cells, 0);
      for (std::size_t i = 1; i <= n; ++i)
        for (const std::size_t cell : shard_cells(cells, i, n)) ++owners.at(cell);
      CHECK(owners == std::vector<int>(cells, 1));
    }
  }
}

TEST_CASE(
    "A list of cells is written as an array reads it, and an array has no more tasks than Slurm takes") {
  CHECK(cell_list({}).empty());
  CHECK(cell_list({0, 3, 4, 5, 7, 9, 10}) == "0,3-5,7,9-10");
  CHECK(ArrayScript{"/p", "/f", 54}.tasks() == 54);
  const ArrayScript large{"/p", "/it's", 2500};
  CHECK(large.tasks() == 1000);
  CHECK_THAT(large.text(), Contains("--array=0-999\n") && Contains("cell < 2500; cell += 1000") &&
                               Contains("folder='/it'\\''s'"));
}

TEST_CASE("What is missing is run again by its array tasks, or without a script by the cells themselves") {
  const testing::TempFolder folder;
  const std::string place = folder.file("");
  CHECK(resubmit_command("/p", place, {3, 4, 9}) ==
        std::vector<std::string>{"/p", "bench", "--cell", "3-4,9", "--out", place});
  remember_script(place, "/s.sh", ArrayScript{"/p", place, 2500});
  CHECK(resubmit_command("/p", place, {3, 4, 1004, 2003}) ==
        std::vector<std::string>{"sbatch", "--array=3-4", "/s.sh"});
}

TEST_CASE("The spread over logs is mean, lowest and highest, and the front is that of the means") {
  const auto log = [](std::vector<double> errors, std::vector<double> loads) {
    Sweep sweep;
    sweep.error = "ate_rmse_m";
    for (std::size_t i = 0; i < errors.size(); ++i) {
      SweepCell cell;
      cell.values = {std::to_string(i)};
      cell.profile_choice = i == 1;
      cell.errors["ate_rmse_m"] = errors[i];
      cell.load_us_per_s = loads[i];
      sweep.cells.push_back(cell);
    }
    return LogSweep{"a.lcm", sweep};
  };
  // The third is the best of the first log alone; over both it is neither cheap nor good.
  const SweepSet set =
      make_sweep_set({log({1, 2, 0.5, 3}, {30, 10, 30, 1}), log({3, 4, 8.5, std::nan("")}, {50, 30, 50, 1})});
  REQUIRE(set.spread.size() == 4);
  CHECK(set.spread[0].error.mean == 2);
  CHECK(set.spread[0].error.low == 1);
  CHECK(set.spread[0].error.high == 3);
  CHECK(set.spread[1].load_us_per_s.mean == 20);
  CHECK(set.spread[2].error.high == 8.5);
  CHECK(set.spread[3].logs == 1);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(set.spread[i].on_front == (i < 2));
    CHECK(set.spread[i].profile_choice == (i == 1));
  }
  LogSweep other = log({1}, {1});
  other.sweep.error = "map_disagreement";
  const SweepSet mixed = make_sweep_set({log({1}, {1}), other});
  CHECK(mixed.spread.empty());
  REQUIRE(mixed.warnings.size() == 1);
  CHECK_THAT(mixed.warnings[0], Contains("--error"));
}
