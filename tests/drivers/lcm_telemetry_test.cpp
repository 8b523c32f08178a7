// SPDX-License-Identifier: BSD-3-Clause
// Telemetry messages against lcm-gen's code.
#include <catch2/catch.hpp>
#include <span>
#include <vector>

#include "drivers/wire_records.hpp"
#include "drivers/wire_telemetry.hpp"
#include "sortie/exec_stats_t.hpp"
#include "sortie/fields_t.hpp"
#include "sortie/pool_stats_t.hpp"
#include "sortie/timing_t.hpp"
#include "tests/drivers/message_bytes.hpp"

using namespace sortie;
using namespace sortie::drivers;
using namespace sortie::test;

TEST_CASE("telemetry is written as lcm-gen writes it and comes back") {
  const ExecStats tasks{33, {{"attitude", 10, 1, 1.5, 2.5, 9.0, 20.0}, {"odometry", 11, 0, 3, 4, 5, 6}}};
  exec_stats_t twin{};
  twin.utime = 33;
  twin.n = 2;
  twin.task = {"attitude", "odometry"};
  twin.count = {10, 11};
  twin.missed = {1, 0};
  twin.p50_us = {1.5, 3};
  twin.p99_us = {2.5, 4};
  twin.max_us = {9, 5};
  twin.budget_us = {20, 6};
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(tasks, out, size); });
  CHECK(bytes == generated_bytes(twin));
  ExecStats back;
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.utime == 33);
  REQUIRE(back.rows.size() == 2);
  CHECK(back.rows[1].task == "odometry");
  CHECK(back.rows[0].budget_us == 20.0);

  const PoolStats pools{34, {{"voxels", 100, 50, 60, 2}}};
  pool_stats_t pool_twin{};
  pool_twin.utime = 34;
  pool_twin.n = 1;
  pool_twin.pool = {"voxels"};
  pool_twin.capacity = {100};
  pool_twin.used = {50};
  pool_twin.high_water = {60};
  pool_twin.refused = {2};
  const Bytes pool_bytes = exact([&](auto out, auto& size) { return encode(pools, out, size); });
  CHECK(pool_bytes == generated_bytes(pool_twin));
  PoolStats pools_back;
  REQUIRE(decode(pool_bytes, pools_back) == Status::ok);
  CHECK(pools_back.rows[0].high_water == 60);

  const std::vector<NamedValue> command{{"stamp_ns", 0}, {"left_m_s", 0.25}, {"right_m_s", 0},
                                        {"waypoint", 7}, {"flags", 0},       {"asked", 3}};
  fields_t fields_twin{};
  fields_twin.utime = 35;
  fields_twin.task = "drive";
  fields_twin.n = 6;
  fields_twin.name = {"stamp_ns", "left_m_s", "right_m_s", "waypoint", "flags", "asked"};
  fields_twin.value = {0, 0.25, 0, 7, 0, 3};
  const Bytes field_bytes = exact([&](auto out, auto& size) {
    return encode(FieldsView{35, "drive", command}, out, size);
  });
  CHECK(field_bytes == generated_bytes(fields_twin));
  FieldsMessage fields_back;
  REQUIRE(decode(field_bytes, fields_back) == Status::ok);
  CHECK(fields_back.task == "drive");
  REQUIRE(fields_back.values.size() == 6);
  CHECK(fields_back.values[1].name == "left_m_s");
  CHECK(fields_back.values[1].value == 0.25);
}

TEST_CASE("job timing is written as lcm-gen writes it and comes back") {
  const std::uint32_t durations[] = {7, 0xFFFFFFFFu};
  const JobTiming timing{5, 2, -9, durations};
  timing_t twin{};
  twin.tick = 5;
  twin.group = 2;
  twin.started_ns = -9;
  twin.ntasks = 2;
  twin.duration_ns = {7, 0xFFFFFFFF};
  const Bytes bytes = exact([&](auto out, auto& size) { return encode(timing, out, size); });
  CHECK(bytes == generated_bytes(twin));
  JobTimingRecord back;
  REQUIRE(decode(bytes, back) == Status::ok);
  CHECK(back.started_ns == -9);
  CHECK(back.duration_ns == std::vector<std::int64_t>{7, 0xFFFFFFFF});
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    REQUIRE(decode(std::span(bytes).first(length), back) == Status::malformed);
  }

  const std::vector<NamedValue> values{{"a", 1.5}, {"b[1]", -2}};
  const FieldsView view{1, "task", values};
  const Bytes list = exact([&](auto out, auto& size) { return encode(view, out, size); });
  FieldsMessage fields;
  REQUIRE(decode(list, fields) == Status::ok);
  REQUIRE(fields.values.size() == 2);
  CHECK(fields.values[1].name == "b[1]");
  CHECK(fields.values[1].value == -2.0);
}
