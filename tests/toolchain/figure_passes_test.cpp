// SPDX-License-Identifier: BSD-3-Clause
// Several runs of one benchmark: ranges hold all of them, and what should be exact and is not is named.
#include <catch2/catch.hpp>

#include "firmware_like/scene/json.hpp"
#include "toolchain/bench/figure_passes.hpp"

using namespace sortie::firmware;

using namespace sortie::toolchain;

namespace {

Json timed(double value, double low, double high, bool met) {
  const auto spread = [](double v, double l, double h) {
    return Json{{"value", v}, {"low", l}, {"high", h}};
  };
  return {{"group", "speed"},
          {"what", "a step"},
          {"unit", "us"},
          {"n", 10u},
          {"peer", "theirs"},
          {"ours", spread(value, low, high)},
          {"theirs", spread(10, 9, 11)},
          {"ratio", spread(value / 10, low / 11, high / 9)},
          {"met", met}};
}

Json exact(double value) {
  return {{"group", "errors"},
          {"what", "position"},
          {"unit", "m"},
          {"n", 3u},
          {"ours", {{"value", value}, {"low", value - 1}, {"high", value + 1}}}};
}

}  // namespace

TEST_CASE("what is a time is told by its unit, and a range in metres is one over seeds") {
  CHECK(is_timed_figure(timed(1, 1, 1, true)));
  CHECK_FALSE(is_timed_figure(exact(2)));
  Json plain{{"unit", ""}, {"ours", {{"value", 2.0}}}};
  CHECK_FALSE(is_timed_figure(plain));
  plain["ours"]["low"] = 1.0;
  CHECK(is_timed_figure(plain));
}

TEST_CASE("a later pass widens ranges, means values, and a goal is met when all met it") {
  Json result{{"figures", {timed(2, 1.5, 2.5, true), exact(5)}}};
  take_pass(result, {{"figures", {timed(4, 3.5, 4.5, true), exact(5)}}}, 1, false);
  take_pass(result, {{"figures", {timed(3, 2.5, 9, false), exact(5)}}}, 2, false);
  const Json& figure = result["figures"][0];
  CHECK(figure["ours"]["value"] == 3.0);
  CHECK(figure["ours"]["low"] == 1.5);
  CHECK(figure["ours"]["high"] == 9.0);
  CHECK(figure["ratio"]["low"].get<double>() == Approx(1.5 / 11));
  CHECK(figure["ratio"]["high"].get<double>() == Approx(1.0));
  CHECK(figure["n"] == 30);
  CHECK(figure["met"] == false);
  CHECK(result["figures"][1] == exact(5));
  CHECK_FALSE(result.contains("unsteady"));
}

TEST_CASE("an error that is another one in the next process is named") {
  Json result{{"figures", {timed(2, 1.5, 2.5, true), exact(5)}}};
  take_pass(result, {{"figures", {timed(2, 1.5, 2.5, true), exact(5.000001)}}}, 1, false);
  REQUIRE(result["unsteady"].size() == 1);
  CHECK(result["unsteady"][0] == "errors: position");
  // Where all is timed nothing is exact; a figure that is missing in one pass is named as well.
  Json times{{"figures", {exact(5), exact(6)}}};
  take_pass(times, {{"figures", Json::array({exact(7)})}}, 1, true);
  CHECK(times["figures"][0]["ours"]["value"] == 6.0);
  REQUIRE(times["unsteady"].size() == 1);
}
