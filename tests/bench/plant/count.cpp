// SPDX-License-Identifier: BSD-3-Clause
// Instructions of a step, exact: this program again, under callgrind.
#include <cmath>

#include "tests/bench/plant/plant_parts.hpp"
#include "tests/bench/report/counted_child.hpp"
#include "toolchain/bench/instruction_count.hpp"

namespace sortie::bench {

namespace {

constexpr double kStep_s = 1e-3;
constexpr const char* kGroup = "instructions";

}  // namespace

int run_counted_drives(const PlantSettings& settings) {
  toolchain::start_counting();
  for (const BenchScene* scene : chosen_scenes(settings)) {
    OwnVehicle ours(*scene);
    const std::unique_ptr<BenchVehicle> theirs = make_ode_vehicle(*scene, OdeSolver::quick);
    settle(ours, *scene, kStep_s);
    if (theirs != nullptr) settle(*theirs, *scene, kStep_s);
    for (BenchVehicle* vehicle : {static_cast<BenchVehicle*>(&ours), theirs.get()}) {
      if (vehicle == nullptr) continue;
      const DrivePlan plan(*scene);
      const long steps = std::lround(scene->seconds / kStep_s);
      toolchain::mark_count();
      for (long i = 0; i < steps; ++i)
        vehicle->step(plan.belts(static_cast<double>(i) * kStep_s, kStep_s), kStep_s);
      toolchain::mark_count();
    }
  }
  return 0;
}

void measure_plant_count(const PlantSettings& settings, Report& report) {
  tell("instructions of a step (some minutes)");
  std::vector<std::string> command{settings.program, "--counted-drives"};
  if (!settings.scene.empty()) command.insert(command.end(), {"--scene", settings.scene});
  const Marks counted = count_instructions(command);
  const std::vector<const BenchScene*> scenes = chosen_scenes(settings);
  const std::size_t engines = has_ode() ? 2 : 1;
  if (!counted.why_none.empty() || counted.instructions.size() != 2 * engines * scenes.size()) {
    report.skip("instructions of a step", counted.why_none.empty() ? "marks are missing" : counted.why_none);
    return;
  }
  double sums[2] = {0, 0};
  std::uint64_t all_steps = 0;
  std::size_t at = 0;
  const auto add = [&](const std::string& what, std::uint64_t steps, const double(&per_step)[2]) {
    Figure figure{kGroup, what, "", steps, spread(per_step[0]), {}, {}, {}, {}, {}};
    if (engines == 2) {
      figure.peer = "ODE QuickStep, 20 iterations";
      figure.theirs = spread(per_step[1]);
      figure.ratio = spread(per_step[0] / per_step[1]);
    }
    report.add(figure);
  };
  for (const BenchScene* scene : scenes) {
    const auto steps = static_cast<std::uint64_t>(std::lround(scene->seconds / kStep_s));
    double per_step[2] = {0, 0};
    for (std::size_t e = 0; e < engines; ++e, at += 2) {
      per_step[e] = static_cast<double>(counted.instructions[at + 1] - counted.instructions[at]) /
                    static_cast<double>(steps);
      sums[e] += per_step[e] / static_cast<double>(scenes.size());
    }
    all_steps += steps;
    add(std::string("of a step, ") + scene->name, steps, per_step);
  }
  if (scenes.size() > 1) add("of a step, mean of the scenes", all_steps, sums);
  report.note(kGroup,
              "Counted by callgrind over whole drives at 1 ms: these do not depend on the machine's load.");
}

}  // namespace sortie::bench
