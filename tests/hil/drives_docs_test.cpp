// SPDX-License-Identifier: BSD-3-Clause
// What the pages say of drives: every test that a table names exists, and every bound is the one that is
// checked.
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/hil/stopping.hpp"

using namespace sortie::hil::test;

namespace {

std::string page(const std::string& name) {
  std::ifstream file(std::string(SORTIE_SOURCE_DIR) + "/docs/" + name);
  std::stringstream text;
  text << file.rdbuf();
  REQUIRE_FALSE(text.str().empty());
  return text.str();
}

std::string trimmed(const std::string& text) {
  const std::size_t from = text.find_first_not_of(' ');
  return from == std::string::npos ? std::string() : text.substr(from, text.find_last_not_of(' ') - from + 1);
}

// Cells of the rows of the table whose head begins so.
std::vector<std::vector<std::string>> table(const std::string& text, const std::string& head) {
  std::vector<std::vector<std::string>> rows;
  const std::size_t at = text.find("\n" + head);
  REQUIRE(at != std::string::npos);
  std::istringstream lines(text.substr(at + 1));
  std::string line;
  for (int number = 0; std::getline(lines, line) && line.rfind("|", 0) == 0; ++number) {
    if (number < 2) continue;
    std::vector<std::string>& cells = rows.emplace_back();
    std::istringstream parts(line.substr(1));
    for (std::string cell; std::getline(parts, cell, '|');) cells.push_back(trimmed(cell));
  }
  return rows;
}

bool is_a_test(const std::string& part) {
  for (const Catch::TestCase& test : Catch::getAllTestCasesSorted(*Catch::getCurrentContext().getConfig())) {
    if (test.name.find(part) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("docs: every test that the tables of what a drive may do name is one of this program") {
  CHECK_FALSE(is_a_test("no test has this name, but for a part of it"));
  const std::pair<const char*, const char*> tables[] = {{"canopen.md", "| a real drive |"},
                                                        {"odrive.md", "| a real axis |"}};
  for (const auto& [file, head] : tables) {
    const auto rows = table(page(file), head);
    CHECK(rows.size() >= 9);
    for (const auto& cells : rows) {
      INFO(file << ": " << cells[0]);
      REQUIRE(cells.size() == 3);
      std::istringstream names(cells[2]);
      int count = 0;
      for (std::string name; std::getline(names, name, ';'); ++count) {
        CAPTURE(name);
        CHECK(is_a_test(trimmed(name)));
      }
      CHECK(count > 0);
    }
  }
}

TEST_CASE("docs: the bounds of docs/safety.md are those that the judge and the runs have") {
  const std::string text = page("safety.md");
  const StopBounds bounds;
  std::map<std::string, int> stated;
  for (const auto& cells : table(text, "| from |")) stated[cells[0]] = std::stoi(cells[1]);
  CHECK(stated.size() == 5);
  CHECK(stated["a command that ends, an emergency stop, a fault that was told"] == bounds.command);
  CHECK(stated["the last command of a source that falls silent"] == bounds.silence);
  CHECK(stated["a fault"] == bounds.fault);
  CHECK(stated["a loss that nobody tells of"] == bounds.loss);
  CHECK(stated["an emergency stop, until no drive has torque"] == bounds.no_torque);

  const auto rows = table(text, "| cause |");
  const std::map<std::string, std::vector<StopCause>> causes = {
      {"a source falls silent", {StopCause::silence}},
      {"a drive loses its power", {StopCause::loss}},
      {"a drive lives and is not read any more", {StopCause::mute}},
      {"a drive has a fault", {StopCause::fault}},
      {"our controller is off the bus; the process is stopped or killed",
       {StopCause::bus_off, StopCause::process_stopped, StopCause::process_killed}},
      {"emergency stop", {StopCause::emergency_stop}}};
  CHECK(rows.size() == causes.size());
  for (const auto& cells : rows) {
    INFO(cells[0]);
    REQUIRE(causes.count(cells[0]) == 1);
    for (const StopCause cause : causes.at(cells[0])) {
      CHECK(std::stoi(cells[1]) == promised<CanopenKind>(cause, false).ms);
      CHECK(std::stoi(cells[2]) == promised<CanopenKind>(cause, true).ms);
      CHECK(std::stoi(cells[3]) == promised<OdriveKind>(cause, false).ms);
      CHECK(std::stoi(cells[4]) == promised<OdriveKind>(cause, true).ms);
    }
  }
}
