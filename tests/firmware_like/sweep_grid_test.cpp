// SPDX-License-Identifier: BSD-3-Clause
// What a sweep runs and which of its results are worth having: the syntax of a knob, the order of the grid,
// the Pareto front against brute force.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "firmware_like/bench/pareto.hpp"
#include "firmware_like/bench/sweep.hpp"
#include "tests/firmware_like/run_support.hpp"

using namespace sortie;
using namespace sortie::firmware;
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
