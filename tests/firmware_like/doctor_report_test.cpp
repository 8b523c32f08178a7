// SPDX-License-Identifier: BSD-3-Clause
// What the doctor has found, as JSON and back and as a table.
#include <catch2/catch.hpp>
#include <sstream>

#include "firmware_like/doctor/doctor_command.hpp"
#include "firmware_like/scene/json.hpp"
#include "tests/firmware_like/doctor_board.hpp"

using namespace sortie;
using namespace sortie::firmware;
using sortie::testing::Board;
using sortie::testing::finding;
using sortie::testing::kCpu;

TEST_CASE("a report survives its JSON form and damaged JSON is named") {
  Board board;
  board.limits("8388608", "0");
  DoctorReport report = board.report();
  report.note = "said \"so\"";
  const DoctorReport again = doctor_from_json(Json::parse(to_json(report).dump()));
  CHECK(to_json(again).dump() == to_json(report).dump());
  CHECK(again.present);
  CHECK(to_json(report).at("verdict") == "bad");
  for (const char* text :
       {"[]", "{\"findings\":3}", "{\"findings\":[{\"name\":\"x\",\"verdict\":\"sick\"}]}", "{\"note\":1}"}) {
    INFO(text);
    CHECK_THROWS_AS(doctor_from_json(Json::parse(text)), std::runtime_error);
  }
}

TEST_CASE("the table puts the worst first and keeps each cure on one line") {
  Board board;
  board.limits("8388608", "99");
  board.set(kCpu + "isolated", "");
  std::ostringstream out;
  const DoctorReport report = board.report();
  print_doctor(out, report);
  const std::string text = out.str();
  CHECK(text.find("bad     memory_lock") == 0);
  CHECK(text.find("warn    isolated_cores") < text.find("good    "));
  CHECK(text.find("cure: " + finding(report, "isolated_cores").cure + "\n") != std::string::npos);
  CHECK(text.find("bad: memory_lock; 1 to improve, 14 good\n") != std::string::npos);
  CHECK(text.find('\033') == std::string::npos);
}
