// SPDX-License-Identifier: BSD-3-Clause
// docs/pitfalls.md says for each pitfall what shows it: every case and every test that it names is there.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/stability/stability.hpp"

namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

// Names as they stand between the first quotes of TEST_CASE.
std::set<std::string> names_of_tests(const fs::path& folder) {
  std::set<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = contents(entry.path());
    const std::string begin = std::string("TEST_CASE") + '(';
    for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
      const std::size_t open = text.find('"', at);
      names.insert(text.substr(open + 1, text.find('"', open + 1) - open - 1));
    }
  }
  return names;
}

// What the last column of a row names, and whether it is a case of the catalogue.
struct Proof {
  std::string name;
  bool is_case;
};

// `bad`: gets what cannot be read.
std::vector<Proof> proofs_of(const std::string& page, std::vector<std::string>& bad) {
  std::vector<Proof> proofs;
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("| ", 0) != 0 || line.find("| shown by |") != std::string::npos) continue;
    const std::size_t end = line.rfind(" |");
    const std::size_t begin = line.rfind("| ", end - 1) + 2;
    std::istringstream cell(line.substr(begin, end - begin));
    for (std::string part; std::getline(cell, part, ';');) {
      part.erase(0, part.find_first_not_of(' '));
      const bool is_case = part.rfind("case: ", 0) == 0;
      if (!is_case && part.rfind("test: ", 0) != 0) {
        bad.push_back(part);
        continue;
      }
      proofs.push_back({part.substr(6), is_case});
    }
  }
  return proofs;
}

std::vector<std::string> missing(const std::string& page) {
  std::vector<std::string> lacking;
  const std::vector<Proof> proofs = proofs_of(page, lacking);
  static const std::set<std::string> tests = names_of_tests(fs::path(SORTIE_SOURCE_DIR) / "tests");
  std::set<std::string> cases;
  for (const sortie::bench::StabilityCase& one : sortie::bench::stability_cases()) cases.insert(one.name);
  for (const Proof& proof : proofs) {
    if ((proof.is_case ? cases : tests).count(proof.name) == 0) lacking.push_back(proof.name);
  }
  return lacking;
}

}  // namespace

TEST_CASE("Every pitfall names cases and tests that are there") {
  const std::string page = contents(fs::path(SORTIE_SOURCE_DIR) / "docs/pitfalls.md");
  std::vector<std::string> bad;
  CHECK(proofs_of(page, bad).size() > 100);
  for (const std::string& name : missing(page))
    FAIL_CHECK("docs/pitfalls.md names what is not there: " << name);
}

TEST_CASE("Every case of the catalogue belongs to a pitfall") {
  const std::string page = contents(fs::path(SORTIE_SOURCE_DIR) / "docs/pitfalls.md");
  for (const sortie::bench::StabilityCase& one : sortie::bench::stability_cases()) {
    INFO(one.name);
    CHECK(page.find("case: " + std::string(one.name)) != std::string::npos);
  }
}

TEST_CASE("A pitfall that names a test that is not there is found") {
  const std::string row =
      "| a | b | c | test: A pitfall that names a test that is not there is found; case: no such case; a "
      "word |\n";
  CHECK(missing(row) == std::vector<std::string>{"a word", "no such case"});
}

TEST_CASE("The table in README is the one that its results page holds") {
  const std::string results = contents(fs::path(SORTIE_SOURCE_DIR) / "docs/results/scene-builds.md");
  std::istringstream lines(contents(fs::path(SORTIE_SOURCE_DIR) / "README.md"));
  int rows = 0;
  bool is_in_table = false;
  for (std::string line; std::getline(lines, line);) {
    is_in_table = line.rfind("| scene | bytes |", 0) == 0 || (is_in_table && line.rfind("|", 0) == 0);
    if (!is_in_table) continue;
    INFO(line);
    CHECK(results.find(line + "\n") != std::string::npos);
    ++rows;
  }
  CHECK(rows >= 10);
}
