// SPDX-License-Identifier: BSD-3-Clause
// How deep contacts get on obstacles, and what the solver leaves unaccounted for.
#include <algorithm>
#include <cstdio>

#include "tests/bench/plant/plant_parts.hpp"
#include "tests/hil/judge/natural_residual.hpp"

namespace sortie::bench {

namespace {

constexpr const char* kGroup = "penetration";
constexpr double kResidualShare = 1e-4;

struct DepthLimit {
  double dt_s;
  double most_m;
};
constexpr DepthLimit kLimits[] = {{1e-3, 1e-3}, {5e-3, 3e-3}};

// One drive of ours with its residual watched.
struct Watched {
  double deepest_m{};
  double residual{};  // largest natural residual over m g dt
  std::uint64_t not_converged{};
  std::uint64_t steps{};
  std::uint32_t contacts{};
};

Watched watch(const BenchScene& scene, double dt_s) {
  OwnVehicle vehicle(scene);
  const hil::TrackedPlant& plant = vehicle.plant();
  Watched seen;
  drive(vehicle, scene, dt_s, [&](long) {
    const hil::ContactProblem& problem = plant.problem();
    seen.residual = std::max(seen.residual, hil::natural_residual(problem, problem.compliance));
    seen.contacts = std::max(seen.contacts, plant.report().contacts);
  });
  seen.deepest_m = vehicle.deepest_m();
  seen.residual /= plant.model().mass_kg() * 9.81 * dt_s;
  seen.not_converged = plant.counters().not_converged;
  seen.steps = plant.counters().steps;
  return seen;
}

Figure plain(const std::string& what, const char* unit, std::uint64_t n, double value) {
  return {kGroup, what, unit, n, spread(value), {}, {}, {}, {}, {}};
}

}  // namespace

void measure_plant_depth(const PlantSettings& settings, Report& report) {
  const std::vector<const BenchScene*> scenes = chosen_obstacles(settings);
  if (scenes.empty()) return;
  Json rows = Json::array();
  for (const DepthLimit& limit : kLimits) {
    double deepest = 0;
    double theirs_deepest = 0;
    double residual = 0;
    std::uint64_t steps = 0;
    for (const BenchScene* scene : scenes) {
      tell(std::string("penetration: ") + scene->name);
      const Watched seen = watch(*scene, limit.dt_s);
      deepest = std::max(deepest, seen.deepest_m);
      residual = std::max(residual, seen.residual);
      steps += seen.steps;
      Json row{scene->name,        1e3 * limit.dt_s, 1e3 * seen.deepest_m, seen.residual,
               seen.not_converged, seen.steps,       seen.contacts};
      for (const OdeSolver solver : {OdeSolver::quick, OdeSolver::dantzig}) {
        const std::unique_ptr<BenchVehicle> theirs = make_ode_vehicle(*scene, solver);
        if (theirs == nullptr) {
          row.push_back("");
          continue;
        }
        drive(*theirs, *scene, limit.dt_s);
        row.push_back(1e3 * theirs->deepest_m());
        if (solver == OdeSolver::quick) theirs_deepest = std::max(theirs_deepest, theirs->deepest_m());
      }
      rows.push_back(row);
    }
    char at[32];
    std::snprintf(at, sizeof(at), " at %g ms", 1e3 * limit.dt_s);
    Figure depth = plain(std::string("deepest contact") + at, "mm", steps, 1e3 * deepest);
    if (theirs_deepest > 0) {
      depth.peer = "ODE QuickStep, 20 iterations";
      depth.theirs = spread(1e3 * theirs_deepest);
      depth.ratio = spread(deepest / theirs_deepest);
    }
    char words[32];
    std::snprintf(words, sizeof(words), "<= %g mm", 1e3 * limit.most_m);
    set_goal(depth, words, deepest <= limit.most_m);
    report.add(depth);
    Figure left = plain(std::string("natural residual over m g dt") + at, "", steps, residual);
    set_goal(left, "<= 1e-4", residual <= kResidualShare);
    report.add(left);
  }
  report.add_table(kGroup,
                   {"scene", "step ms", "deepest mm", "residual over m g dt", "not converged", "steps",
                    "most contacts", "QuickStep deepest mm", "Step deepest mm"},
                   rows);
  report.note(
      kGroup,
      "A step that no method ended within its limits is counted under not converged: the best answer met was "
      "taken, and the next step starts from it.");
  report.note(kGroup, "ODE lets contacts sink by its surface layer of 1 mm before it pushes them out.");
}

}  // namespace sortie::bench
