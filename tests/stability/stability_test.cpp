// SPDX-License-Identifier: BSD-3-Clause
// Every stiff or extreme case: ours within the bound, the naive method outside it.
#include "tests/bench/stability/stability.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <string>

namespace {
using namespace sortie;

// How many cases do not hold, each named.
int broken_cases(bool heavy, int& tried) {
  int broken = 0;
  for (const bench::StabilityCase& one : bench::stability_cases()) {
    if (one.heavy != heavy) continue;
    ++tried;
    const bench::StabilityFigures got = one.run();
    const bool good = bench::within(got.ours, one.bound);
    const bool caught = !bench::within(got.naive, one.bound);
    if (good && caught) continue;
    ++broken;
    UNSCOPED_INFO(one.group << ", " << one.name << ": ours " << got.ours << ", naive " << got.naive
                            << ", bound " << one.bound);
  }
  return broken;
}
}  // namespace

TEST_CASE("Stiff and extreme cases: ours within the bound, the naive method outside") {
  int tried = 0;
  CHECK(broken_cases(false, tried) == 0);
  CHECK(tried >= 25);
}

TEST_CASE("Long stiff and extreme cases: ours within the bound, the naive method outside", "[heavy]") {
  int tried = 0;
  CHECK(broken_cases(true, tried) == 0);
  CHECK(tried >= 1);
}

TEST_CASE("What is no number, or infinite, is within no bound") {
  CHECK_FALSE(bench::within(std::nan(""), 1e300));
  CHECK_FALSE(bench::within(std::numeric_limits<double>::infinity(), 1e300));
  CHECK(bench::within(0.0, 0.0));
}

TEST_CASE("Cases of the catalogue are told apart and told in full") {
  std::set<std::string> names;
  std::set<std::string> groups;
  for (const bench::StabilityCase& one : bench::stability_cases()) {
    names.insert(one.name);
    groups.insert(one.group);
    for (const char* text : {one.why, one.naive, one.ours, one.measure}) {
      CHECK(std::string(text).size() >= 2);
      CHECK(std::string(text).find('|') == std::string::npos);
    }
    CHECK(std::isfinite(one.bound));
  }
  CHECK(names.size() == bench::stability_cases().size());
  CHECK(groups == std::set<std::string>{"drivers", "estimators", "hil", "mapping", "planner", "rt"});
}

TEST_CASE("docs/stability.md holds the catalogue that is tested") {
  std::ifstream file(SORTIE_SOURCE_DIR "/docs/stability.md");
  const std::string page{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const std::string catalogue = bench::stability_catalogue();
  // Written by `sortie-bench-stability --catalogue`.
  CHECK(page.find(catalogue) != std::string::npos);
}
