// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-stability: runs the catalogue of stiff and extreme cases and prints one JSON object.
// `sortie bench stability` runs it and shows the table.
#include <cmath>
#include <iostream>
#include <stdexcept>

#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/figures.hpp"
#include "tests/bench/stability/kernels.hpp"
#include "tests/bench/stability/stability.hpp"

namespace sortie::bench {

namespace {

// JSON has no infinity.
Json figure_of(double value) {
  if (std::isnan(value)) return "not a number";
  if (std::isinf(value)) return "infinite";
  return value;
}

int run_stability(int argc, char** argv) {
  std::string only;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--catalogue") {
      std::cout << stability_catalogue();
      return 0;
    }
    if (option != "--only" || ++i >= argc) throw std::invalid_argument("unknown option " + option);
    only = argv[i];
  }
  Json root;
  root["settings"] = {{"only", only}};
  Json rows = Json::array();
  int kept = 0;
  int caught = 0;
  for (const StabilityCase& one : stability_cases()) {
    if (!only.empty() && only != one.group) continue;
    std::cerr << "stability: " << one.name << "\n";
    const StabilityFigures got = one.run();
    const bool good = within(got.ours, one.bound);
    const bool outside = !within(got.naive, one.bound);
    kept += good ? 1 : 0;
    caught += outside ? 1 : 0;
    rows.push_back({{"group", one.group},
                    {"what", one.name},
                    {"why", one.why},
                    {"naive_method", one.naive},
                    {"our_method", one.ours},
                    {"measured", one.measure},
                    {"bound", one.bound},
                    {"ours", figure_of(got.ours)},
                    {"naive", figure_of(got.naive)},
                    {"ours_within", good},
                    {"naive_outside", outside},
                    {"met", good && outside}});
  }
  if (rows.empty())
    throw std::invalid_argument("--only takes rt, drivers, estimators, mapping, planner or hil");
  root["summary"] = {{"cases", rows.size()}, {"ours_within", kept}, {"naive_outside", caught}};
  root["figures"] = rows;
  root["tables"] = Json::array();
  if (only.empty()) root["tables"].push_back(kernel_table());
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-stability",
                                     [argc, argv] { return sortie::bench::run_stability(argc, argv); });
}
