// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-rays: measures the ray scheduler beside the published planners and prints one JSON object.
// `sortie bench rays` runs it and shows the table.
#include <iostream>
#include <stdexcept>

#include "tests/bench/rays/ray_parts.hpp"
#include "tests/bench/report/arguments.hpp"

namespace sortie::bench {

namespace {

struct RayPart {
  const char* name;
  void (*measure)(const RaySettings&, Report&);
};
constexpr RayPart kRayParts[] = {
    {"curves", measure_ray_curves}, {"units", measure_ray_units}, {"picture", measure_ray_picture}};

int run(int argc, char** argv) {
  RaySettings settings;
  std::string only;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const char* value = ++i < argc ? argv[i] : nullptr;
    if (option == "--rounds")
      settings.rounds = static_cast<int>(number("--rounds", value, 1, 1e4));
    else if (option == "--seeds")
      settings.seeds = static_cast<int>(number("--seeds", value, 1, 1e3));
    else if (option == "--only" && value != nullptr)
      only = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  for (const char* list : {"figures", "tables", "skipped", "notes"}) root[list] = Json::array();
  root["settings"] = {{"rounds", settings.rounds}, {"seeds", settings.seeds}, {"only", only}};
  bool found = false;
  for (const RayPart& part : kRayParts) {
    if (!only.empty() && only != part.name) continue;
    found = true;
    part.measure(settings, report);
  }
  if (!found) throw std::invalid_argument("--only takes curves, units or picture");
  root["load_after"] = load_average();
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-rays",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
