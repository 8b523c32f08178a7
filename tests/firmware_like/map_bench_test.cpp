// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/map_bench.hpp"

#include <catch2/catch.hpp>
#include <sstream>

namespace sortie::testing {
namespace {

nlohmann::ordered_json map_row(const char* group, double ms, double finest, const char* truth, double held) {
  nlohmann::ordered_json row{{"group", group}, {"knob", "voxel"}, {"value", "0.1 m"}, {"p50_ms", ms}};
  row["finest"] = finest;
  row["held"] = held;
  row["normal_p50_deg"] = "";
  row["truth"] = truth;
  return row;
}

}  // namespace

TEST_CASE("rows of the map's sweep: a front for each group, what is lost counts as wrong") {
  nlohmann::ordered_json result;
  result["map_rows"] = {map_row("a", 1.0, 0.9, "", 1.0), map_row("a", 2.0, 0.95, "", 1.0),
                        map_row("a", 2.0, 0.95, "", 0.5), map_row("a", 3.0, 0.8, "", 1.0),
                        map_row("b", 9.0, 0.1, "", 1.0)};
  firmware::mark_map_rows(result);
  const auto& rows = result["map_rows"];
  const auto front = [&rows](std::size_t i) { return rows[i]["front"].get<bool>(); };
  CHECK(front(0));
  CHECK(front(1));
  CHECK_FALSE(front(2));
  CHECK_FALSE(front(3));
  CHECK(front(4));
  CHECK(rows[2]["error"].get<double>() == Approx(1 - 0.95 * 0.5));
  CHECK(rows[0]["judged"] == "finest");
}

TEST_CASE("where faces are known, smooth segments are judged by them, and each group has a picture") {
  nlohmann::ordered_json result;
  nlohmann::ordered_json smooth = map_row("s", 1.0, 0.9, "", 1.0);
  smooth["normal_p50_deg"] = 0.3;
  smooth["truth"] = 0.6;
  result["map_rows"] = {map_row("e", 1.0, 0.9, "", 1.0), smooth};
  firmware::mark_map_rows(result);
  CHECK(result["map_rows"][1]["judged"] == "truth");
  CHECK(result["map_rows"][1]["error"].get<double>() == Approx(0.4));
  const auto pictures = firmware::map_pictures(result);
  REQUIRE(pictures.size() == 2);
  CHECK(pictures[0].plot.title == "e");
  CHECK(pictures[1].plot.y.label.find("true faces") != std::string::npos);
}

}  // namespace sortie::testing
