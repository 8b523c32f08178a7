// SPDX-License-Identifier: BSD-3-Clause
// The result object: fixed keys, nothing lost in JSON, a table that fits a screen.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <sstream>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"

using namespace sortie::firmware;

namespace {

Results example() {
  Results r;
  r.digest = "9f86d081884c7d65";
  r.ticks = 18446744073709551615u;
  r.scene = "skid_outdoor";
  r.vehicle = "ugv";
  r.duration_s = 199.97;
  r.profile_hash = "0123456789abcdef";
  r.left_out = {"map", "ssl"};
  r.speed = 85.2;
  r.errors = {
      {"ate_rmse_m", 3.2176}, {"ate_n", 500.0}, {"rpe_rmse_m", std::numeric_limits<double>::quiet_NaN()}};
  r.tasks = {{"attitude",
              "imu",
              1000,
              50,
              199900,
              0,
              0.12,
              1.3,
              2.5,
              22.8,
              "ab",
              {{0.1, 0.2, 199000}, {0.2, 30.0, 900}}},
             {"track_odometry_with_a_long_name", "imu", 1000, 50, 199900, 3, 0.32, 1.3, 2.5, 122.8, "", {}},
             {"voxel_grid", "map", 500000, 0, 110, 0, 2532, 8123, 12000, 12001.5, "", {}}};
  GroupResult imu;
  imu.name = "imu";
  imu.period_us = 1000;
  imu.deadline_us = 1000;
  imu.core = 1;
  imu.jobs = 199900;
  imu.skipped = 7;
  imu.worst_in_row = 4;
  imu.late_p99_us = 1.25;
  imu.late_max_us = 7801;
  imu.wake_known = true;
  imu.spinning = 0.016;
  imu.margin_us = 23.5;
  imu.stack_bytes = 9216;
  imu.delays.known = true;
  imu.delays.start = {3, 7801, 12, 199897, {{"stolen", {2, 7900}}, {"run queue", {1, 130.5}}}};
  imu.delays.execution = {1, 300, 300, 199900, {{"own work", {1, 250}}}};
  imu.delays.last = {{1200, "start", 7801, "stolen", {{"stolen", 7700}, {"run queue", 101}}}};
  imu.lateness = {{0.0, 0.1, 199000}, {7700, 7900, 1}};
  imu.response = {{1.0, 2.0, 199900}};
  r.groups = {imu};
  r.pools = {{"voxels", 262144, 262144, 45428, 1u << 24}, {"scans", 8, 3, 0, 1 << 20}};
  r.counters = {{"imu_rejected", 0}, {"track_gaps", 12}};
  r.machine = "machine";
  r.compiler = "compiler";
  r.warnings = {"not real-time"};
  return r;
}

}  // namespace

TEST_CASE("the keys of the JSON interface are those that scripts rely on") {
  const auto json = to_json(example());
  for (const char* key : {"digest", "ticks", "scene", "errors", "tasks", "pools", "counters"})
    CHECK(json.contains(key));
  CHECK(json["errors"]["ate_rmse_m"] == 3.2176);
  CHECK(json["errors"]["rpe_rmse_m"].is_null());
  for (const char* key :
       {"name", "period_us", "budget_us", "count", "missed", "p50_us", "p99_us", "p999_us", "max_us"}) {
    CHECK(json["tasks"][0].contains(key));
  }
  for (const char* key : {"name", "capacity", "high_water", "refused"}) CHECK(json["pools"][0].contains(key));
  CHECK(json["counters"]["track_gaps"] == 12);
  CHECK(json["ticks"] == 18446744073709551615u);
  CHECK(json["tasks"][1]["missed"] == 3);
  CHECK(json["tasks"][0]["p999_us"] == 2.5);
  CHECK(json["pools"][0]["refused"] == 45428);
}

TEST_CASE("the table fits a screen of 100 columns and 25 lines") {
  Results r = example();
  for (int i = 0; i < 40; ++i)
    r.counters["some_counter_number_" + std::to_string(i)] = 1000000u + static_cast<unsigned>(i);
  for (int i = 0; i < 12; ++i) r.errors["error_" + std::to_string(i) + "_m"] = 1.0 / 3.0;
  for (int i = 0; i < 5; ++i) {
    r.warnings.push_back(
        "a warning that is longer than a line of the screen, because it says what happened, where it "
        "happened and how to cure it");
  }
  std::ostringstream out;
  print_table(out, r);
  std::istringstream in(out.str());
  int lines = 0;
  for (std::string line; std::getline(in, line); ++lines) {
    INFO(line);
    CHECK(line.size() <= 100);
    CHECK(line.find('\033') == std::string::npos);
  }
  CHECK(lines <= 30);  // 25 for a usual result
  for (const char* part :
       {"skid_outdoor", "ate_rmse_m 3.22", "rpe_rmse_m -", "voxels 262,144/262,144 (100 %), refused 45,428",
        "p99.9", "attitude", "9f86d081884c7d65", "(--json shows all)"}) {
    INFO(part);
    CHECK(out.str().find(part) != std::string::npos);
  }
  CHECK(out.str().find("imu_rejected") == std::string::npos);  // zero counters are no news
}

TEST_CASE("colour marks misses, and only when asked for") {
  std::ostringstream out;
  print_table(out, example(), true);
  CHECK(out.str().find("\033[31m       3\033[0m") != std::string::npos);
}

TEST_CASE("an empty result still prints") {
  std::ostringstream out;
  print_table(out, Results{});
  CHECK(out.str().find("0 ticks") != std::string::npos);
}

TEST_CASE("machine and compiler are named") {
  CHECK(machine_description().find("core") != std::string::npos);
  CHECK(compiler_description().find("++") != std::string::npos);
}
