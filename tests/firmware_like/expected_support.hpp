// SPDX-License-Identifier: BSD-3-Clause
// Committed outputs of fixed replays: a change of behaviour is then always a decision, never an accident.
#pragma once

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "tests/firmware_like/temp_folder.hpp"

namespace sortie::testing {

inline std::string expected_path(const std::string& name) {
  return std::string(SORTIE_SOURCE_DIR) + "/tests/expected/" + name;
}

/// True when the files are to be written anew instead of compared.
inline bool updates_expected() { return std::getenv("SORTIE_UPDATE_EXPECTED") != nullptr; }

inline std::string how_to_update() {
  return "If this change of behaviour is wanted, run sortie_tests_firmware_like '[expected]' once with "
         "SORTIE_UPDATE_EXPECTED=1 in the environment and commit tests/expected with the change. If it is "
         "not "
         "wanted, or differs between compilers or processors only, it is a fault.";
}

/// Compares a digest with the line "name digest" of tests/expected/digests.txt.
inline void check_expected_digest(const std::string& name, const std::string& digest) {
  std::map<std::string, std::string> lines;
  std::istringstream text(read_all(expected_path("digests.txt")));
  for (std::string key, value; text >> key >> value;) lines[key] = value;
  if (updates_expected()) {
    lines[name] = digest;
    std::ofstream out(expected_path("digests.txt"));
    for (const auto& [key, value] : lines) out << key << " " << value << "\n";
    WARN("updated: " << name << " " << digest);
    return;
  }
  INFO(name << ": " << how_to_update());
  CHECK(lines[name] == digest);
}

/// Compares a text with a file of tests/expected and shows the first line that differs.
inline void check_expected_text(const std::string& name, const std::string& now) {
  if (updates_expected()) {
    std::ofstream(expected_path(name)) << now;
    WARN("updated: " << name);
    return;
  }
  INFO(name << ": " << how_to_update());
  std::istringstream was_lines(read_all(expected_path(name)));
  std::istringstream now_lines(now);
  std::string was_line;
  std::string now_line;
  int number = 0;
  while (true) {
    const bool was_there = static_cast<bool>(std::getline(was_lines, was_line));
    const bool now_there = static_cast<bool>(std::getline(now_lines, now_line));
    INFO("line " << ++number);
    REQUIRE(was_there == now_there);
    if (!was_there) break;
    REQUIRE(was_line == now_line);
  }
}

}  // namespace sortie::testing
