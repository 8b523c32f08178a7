// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-plant: measures the tracked plant beside ODE and prints one JSON object. `sortie bench plant`
// runs it and shows the table.
#include <iostream>
#include <stdexcept>

#include "rt/posix/fast_clock.hpp"
#include "tests/bench/plant/plant_parts.hpp"
#include "tests/bench/report/arguments.hpp"
#include "toolchain/bench/child_process.hpp"

namespace sortie::bench {

namespace {

struct PlantPart {
  const char* name;
  void (*measure)(const PlantSettings&, Report&);
};
constexpr PlantPart kParts[] = {{"speed", measure_plant_speed},      {"count", measure_plant_count},
                                {"metrics", measure_plant_metrics},  {"belt", measure_plant_belt},
                                {"steps", measure_plant_steps},      {"depth", measure_plant_depth},
                                {"pictures", measure_plant_pictures}};

struct PlantArguments {
  PlantSettings settings;
  std::string only;
  bool counted_drives{};
};

PlantArguments parse(int argc, char** argv) {
  PlantArguments all;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--counted-drives") {
      all.counted_drives = true;
      continue;
    }
    const char* value = ++i < argc ? argv[i] : nullptr;
    if (option == "--rounds")
      all.settings.rounds = static_cast<int>(number("--rounds", value, 1, 1e4));
    else if (option == "--only" && value != nullptr)
      all.only = value;
    else if (option == "--scene" && value != nullptr)
      all.settings.scene = value;
    else
      throw std::invalid_argument("unknown option " + option);
  }
  if (chosen_scenes(all.settings).empty()) {
    std::string names;
    for (const BenchScene& scene : bench_scenes()) names += std::string(" ") + scene.name;
    throw std::invalid_argument("--scene takes one of" + names);
  }
  return all;
}

int run(const PlantArguments& arguments) {
  PlantSettings settings = arguments.settings;
  settings.program = toolchain::own_program_path();
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  for (const char* list : {"figures", "tables", "skipped", "notes"}) root[list] = Json::array();
  root["settings"] = {{"rounds", settings.rounds}, {"scene", settings.scene}, {"only", arguments.only}};
  for (const BenchScene* scene : chosen_scenes(settings)) {
    root["scenes"].push_back({{"name", scene->name}, {"about", scene->about}, {"friction", scene->friction}});
  }
  rt::posix::start_fast_clock();
  if (!has_ode())
    report.skip("ODE",
                "not there when this was built; apt-get install libode-dev, then "
                "build sortie-bench-plant again");
  bool found = false;
  for (const PlantPart& part : kParts) {
    if (!arguments.only.empty() && arguments.only != part.name) continue;
    found = true;
    part.measure(settings, report);
  }
  if (!found)
    throw std::invalid_argument("--only takes speed, count, metrics, belt, steps, depth or pictures");
  root["load_after"] = load_average();
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-plant", [argc, argv] {
    const sortie::bench::PlantArguments arguments = sortie::bench::parse(argc, argv);
    return arguments.counted_drives ? sortie::bench::run_counted_drives(arguments.settings)
                                    : sortie::bench::run(arguments);
  });
}
