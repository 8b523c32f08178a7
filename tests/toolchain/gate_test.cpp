// SPDX-License-Identifier: BSD-3-Clause
// Release gates: each kind of bound kept and broken, one line for each that is broken, no bound that cannot
// fail.
#include "toolchain/judge/gate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "firmware_like/scene/profile.hpp"
#include "tests/firmware_like/temp_folder.hpp"

namespace {
using namespace sortie;

firmware::Results gated_results() {
  firmware::Results results;
  results.digest = "00000000000000ab";
  results.scene = "ugv_hall";
  results.vehicle = "ugv";
  results.ticks = 5000;
  results.errors["ate_rmse_m"] = 0.25;
  results.errors["heading_rmse_deg"] = std::nan("");
  results.counters["heap_calls"] = 0;
  results.counters["imu_used"] = 900;
  results.tasks.resize(2);
  results.tasks[0].name = "odometry";
  results.tasks[0].max_us = 1;  // of the machine that replays
  results.tasks[1].name = "map";
  results.tasks[1].max_us = 2;
  results.tasks[0].count = 5000;
  results.tasks[1].count = 50;
  results.live.known = true;
  results.live.tasks = {{"odometry", 5000, 0, 0, 0, 40}, {"map", 50, 0, 0, 0, 3000}};
  results.groups.resize(2);
  results.groups[0].name = "control";
  results.groups[1].name = "mapping";
  results.groups[1].missed = 2;
  results.groups[1].response_max_us = 5200;
  results.groups[1].jobs = 50;
  results.groups[1].lateness = {{0, 100, 50}};
  results.pools.resize(1);
  results.pools[0].name = "voxels";
  results.pools[0].refused = 3;
  results.chains.resize(2);
  results.chains[0].name = "imu_to_pose";
  results.chains[0].age.count = 10;
  results.chains[0].age.max_us = 7000;
  results.chains[1].name = "silent";
  return results;
}

std::vector<std::string> gate(const std::string& text) {
  const testing::TempFolder folder;
  return toolchain::Gate(folder.write("gate.toml", text)).judge(gated_results());
}

bool tells(const std::vector<std::string>& lines, const std::string& words) {
  return lines.size() == 1 && lines[0].find("gate.toml:2: " + words) != std::string::npos;
}
}  // namespace

TEST_CASE("A gate whose bounds are all kept says nothing") {
  CHECK(gate("[max]\nerrors.ate_rmse_m = 0.25\nall.missed = 2\nall.max_us = 3000\nall.refused = 3\n"
             "all.response_max_us = 5200\ngroups.control.missed = 0\ntasks.odometry.max_us = 40\n"
             "chains.imu_to_pose.measured_age.max_us = 7000\n"
             "[min]\ncounters.imu_used = 900\nticks = 5000\n"
             "[equal]\ndigest = \"00000000000000ab\"\nscene = \"ugv_hall\"\nvehicle = \"ugv\"\n")
            .empty());
}

TEST_CASE("A broken bound is one line: place, name, figure, limit") {
  CHECK(tells(gate("[max]\nerrors.ate_rmse_m = 0.2"), "errors.ate_rmse_m = 0.25, at most 0.2"));
  CHECK(tells(gate("[max]\nall.missed = 1"), "all.missed = 2, at most 1"));
  CHECK(tells(gate("[max]\nall.max_us = 2999"), "all.max_us = 3000, at most 2999"));
  CHECK(tells(gate("[max]\nall.response_max_us = 5000"), "all.response_max_us = 5200, at most 5000"));
  CHECK(tells(gate("[max]\nall.refused = 0"), "all.refused = 3, at most 0"));
  CHECK(tells(gate("[max]\npools.voxels.refused = 0"), "pools.voxels.refused = 3, at most 0"));
  CHECK(tells(gate("[max]\ngroups.mapping.missed = 0"), "groups.mapping.missed = 2, at most 0"));
  CHECK(tells(gate("[max]\nchains.imu_to_pose.measured_age.max_us = 6999"),
              "chains.imu_to_pose.measured_age.max_us = 7000, at most 6999"));
  CHECK(tells(gate("[min]\ncounters.imu_used = 1000"), "counters.imu_used = 900, at least 1000"));
  CHECK(tells(gate("[equal]\ndigest = \"ab\""), "digest = 00000000000000ab, wanted ab"));
  CHECK(gate("[max]\nall.missed = 0\nall.refused = 0\n[equal]\nscene = \"uav\"").size() == 3);
}

TEST_CASE("A figure that is no number breaks every bound") {
  CHECK(gate("[max]\nerrors.heading_rmse_deg = 1e300").size() == 1);
  CHECK(gate("[min]\nerrors.heading_rmse_deg = -1e300").size() == 1);
  firmware::Results results = gated_results();
  results.live.tasks[0].max_us = std::nan("");  // and the task after it has a number
  const testing::TempFolder folder;
  CHECK(toolchain::Gate(folder.write("gate.toml", "[max]\nall.max_us = 1e300")).judge(results).size() == 1);
}

TEST_CASE("What no job was measured for is refused, not kept") {
  for (const char* name : {"groups.control.response_max_us", "groups.control.late_max_us"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(gate("[max]\n" + std::string(name) + " = 1e300"), firmware::ProfileError);
  }
}

TEST_CASE("A gate that cannot fail is refused: unknown names, wrong kinds, what was not measured") {
  for (const char* text :
       {"[max]\nerrors.ate_rsme_m = 1", "[maximum]\nerrors.ate_rmse_m = 1", "[max]\nticks = \"many\"",
        "[equal]\ndigest = 12", "[equal]\nticks = \"5000\"", "max = 3", "[max\n", "", "[max]\n", "[equal]\n",
        "[max]\nchains.silent.measured_age.max_us = 1"}) {
    CAPTURE(text);
    CHECK_THROWS_AS(gate(text), firmware::ProfileError);
  }
}
