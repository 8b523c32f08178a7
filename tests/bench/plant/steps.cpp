// SPDX-License-Identifier: BSD-3-Clause
// Error against step size against run time.
#include <algorithm>
#include <iterator>
#include <map>

#include "rt/posix/clock.hpp"
#include "tests/bench/plant/deviation.hpp"
#include "tests/bench/plant/plant_parts.hpp"

namespace sortie::bench {

namespace {

constexpr double kSteps_s[] = {1e-3, 2e-3, 5e-3, 10e-3, 20e-3};
constexpr int kMostRounds = 3;
constexpr const char* kGroup = "step size";

// One way to compute: an engine, with our solver's knob.
struct Way {
  const char* name;
  int newton_iterations;  // 0: QuickStep
};
constexpr Way kWays[] = {{"ours, 2 iterations", 2},
                         {"ours, 4 iterations", 4},
                         {"ours, 8 iterations (default)", 8},
                         {"ours, 16 iterations", 16},
                         {"ODE QuickStep", 0}};

constexpr std::size_t kDefaultWay = 2;

// On planes the knob changes nothing, and the picture is to be read.
bool is_drawn(std::size_t kind, std::size_t way) {
  return kWays[way].newton_iterations == 0 || way == kDefaultWay || (kind == 1 && way == 0);
}

// What a way reached at one step size, over scenes of one kind.
struct StepCell {
  double mean_error_m{};  // mean over scenes and samples
  double worst_end_m{};
  const char* worst_scene{""};
  Rounds us_per_s;  // of all its scenes together
  std::size_t scenes{};
};

std::unique_ptr<BenchVehicle> make_way(const Way& way, const BenchScene& scene) {
  if (way.newton_iterations == 0) return make_ode_vehicle(scene, OdeSolver::quick);
  return std::make_unique<OwnVehicle>(scene, way.newton_iterations);
}

// Errors of all scenes of a kind at one step size; adds one round of time.
void add_round(const Way& way, const std::vector<const BenchScene*>& scenes, double dt_s, StepCell& cell) {
  double us = 0;
  double seconds = 0;
  StepCell fresh;
  for (const BenchScene* scene : scenes) {
    const std::unique_ptr<BenchVehicle> vehicle = make_way(way, *scene);
    BenchPose settled;
    const rt::Nanoseconds before = rt::posix::thread_cpu_now();
    const Path path = sample_drive(*vehicle, *scene, dt_s, &settled);
    us += static_cast<double>(rt::posix::thread_cpu_now() - before) * 1e-3;
    const Deviation d = deviation(path, *scene, settled);
    seconds += scene->seconds + scene->settle_s;
    fresh.mean_error_m += d.sum_d_t / kSamples / static_cast<double>(scenes.size());
    if (d.end_d_t >= fresh.worst_end_m) {
      fresh.worst_end_m = d.end_d_t;
      fresh.worst_scene = scene->name;
    }
  }
  cell.mean_error_m = fresh.mean_error_m;
  cell.worst_end_m = fresh.worst_end_m;
  cell.worst_scene = fresh.worst_scene;
  cell.scenes = scenes.size();
  cell.us_per_s.add(us / seconds);
}

}  // namespace

void measure_plant_steps(const PlantSettings& settings, Report& report) {
  const char* kinds[] = {"closed form", "obstacles"};
  std::vector<const BenchScene*> scenes[2];
  for (const BenchScene* scene : chosen_scenes(settings)) scenes[scene->closed_form ? 0 : 1].push_back(scene);
  std::map<std::pair<std::size_t, std::size_t>, StepCell> cells[2];
  const int rounds = std::min(settings.rounds, kMostRounds);
  for (int round = 0; round < rounds; ++round) {
    tell("step size against error, round " + std::to_string(round + 1) + " of " + std::to_string(rounds));
    for (std::size_t kind = 0; kind < 2; ++kind) {
      if (scenes[kind].empty()) continue;
      for (std::size_t d = 0; d < std::size(kSteps_s); ++d) {
        for (std::size_t w = 0; w < std::size(kWays); ++w) {
          if (kWays[w].newton_iterations == 0 && !has_ode()) continue;
          add_round(kWays[w], scenes[kind], kSteps_s[d], cells[kind][{w, d}]);
        }
      }
    }
  }
  Json rows = Json::array();
  Json& curves = report.root()["step_curves"] = Json::array();
  for (std::size_t kind = 0; kind < 2; ++kind) {
    for (const auto& [at, cell] : cells[kind]) {
      const Way& way = kWays[at.first];
      const double dt_ms = kSteps_s[at.second] * 1e3;
      rows.push_back({kinds[kind], way.name, dt_ms, cell.us_per_s.median(), 1e3 * cell.mean_error_m,
                      1e3 * cell.worst_end_m, cell.worst_scene});
      if (!is_drawn(kind, at.first)) continue;
      curves.push_back({{"kind", kinds[kind]},
                        {"way", way.name},
                        {"dt_ms", dt_ms},
                        {"named", at.first == kDefaultWay || way.newton_iterations == 0},
                        {"us_per_s", cell.us_per_s.median()},
                        {"error_mm", 1e3 * cell.mean_error_m}});
    }
  }
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const auto found = cells[kind].find({kDefaultWay, 2});
    if (found == cells[kind].end()) continue;
    Figure figure{kGroup,
                  std::string("worst end at 5 ms, ") + kinds[kind],
                  "mm",
                  found->second.scenes,
                  spread(1e3 * found->second.worst_end_m),
                  {},
                  {},
                  {},
                  {},
                  {}};
    set_goal(figure, "<= 20 mm", found->second.worst_end_m <= 0.02);
    report.add(figure);
  }
  report.add_table(
      kGroup,
      {"scenes", "way", "step ms", "us per simulated second", "mean d_t mm", "worst end d_t mm", "of scene"},
      rows);
  report.note(kGroup,
              "Run time is CPU time of the measuring thread; errors are against the closed form, or on "
              "obstacles against our plant at 0.25 ms. Iterations are "
              "those of one try of Newton's method: fewer do not make a step cheaper where it then starts "
              "again from convex problems. QuickStep on obstacles also differs in its model (rigid "
              "flippers).");
}

}  // namespace sortie::bench
