// SPDX-License-Identifier: BSD-3-Clause
// Run time of a step, ours and ODE's: the same drive, slices of 250 steps in turn.
#include <algorithm>
#include <array>
#include <cmath>

#include "rt/posix/clock.hpp"
#include "rt/posix/fast_clock.hpp"
#include "tests/bench/plant/plant_parts.hpp"

namespace sortie::bench {

namespace {

constexpr double kStep_s = 1e-3;
constexpr long kSlice = 250;
constexpr int kEngines = 3;
constexpr const char* kEngineNames[kEngines] = {"ours", "ODE QuickStep, 20 iterations", "ODE Step (Dantzig)"};
constexpr const char* kGroup = "speed";

std::unique_ptr<BenchVehicle> make_engine(int engine, const BenchScene& scene) {
  if (engine == 0) return std::make_unique<OwnVehicle>(scene);
  return make_ode_vehicle(scene, engine == 1 ? OdeSolver::quick : OdeSolver::dantzig);
}

// Times of one engine on one scene.
struct StepTimes {
  Rounds steps;    // each step, us by the clock
  Rounds rounds;   // mean of a round, us of this thread
  double round{};  // sum of the round under way
};
using SceneTimes = std::array<StepTimes, kEngines>;

void time_slice(BenchVehicle& vehicle, const DrivePlan& plan, long from, long to, StepTimes& times) {
  const rt::Nanoseconds cpu = rt::posix::thread_cpu_now();
  rt::Nanoseconds before = rt::posix::fast_now();
  for (long i = from; i < to; ++i) {
    vehicle.step(plan.belts(static_cast<double>(i) * kStep_s, kStep_s), kStep_s);
    const rt::Nanoseconds now = rt::posix::fast_now();
    times.steps.add(static_cast<double>(now - before) * 1e-3);
    before = rt::posix::fast_now();
  }
  times.round += static_cast<double>(rt::posix::thread_cpu_now() - cpu) * 1e-3;
}

void time_round(const BenchScene& scene, SceneTimes& times) {
  std::array<std::unique_ptr<BenchVehicle>, kEngines> vehicles;
  for (int e = 0; e < kEngines; ++e) {
    vehicles[static_cast<std::size_t>(e)] = make_engine(e, scene);
    if (vehicles[static_cast<std::size_t>(e)] == nullptr) continue;
    settle(*vehicles[static_cast<std::size_t>(e)], scene, kStep_s);
  }
  const DrivePlan plan(scene);
  const long steps = std::lround(scene.seconds / kStep_s);
  for (StepTimes& one : times) one.round = 0;
  for (long from = 0; from < steps; from += kSlice) {
    rt::posix::anchor_fast_clock();
    for (std::size_t e = 0; e < kEngines; ++e) {
      if (vehicles[e] != nullptr)
        time_slice(*vehicles[e], plan, from, std::min(steps, from + kSlice), times[e]);
    }
  }
  for (std::size_t e = 0; e < kEngines; ++e) {
    if (vehicles[e] != nullptr) times[e].rounds.add(times[e].round / static_cast<double>(steps));
  }
}

Figure beside(const std::string& what, const StepTimes& ours, const StepTimes& theirs, int engine) {
  Figure figure{kGroup, what, "us", ours.steps.size(), spread(ours.rounds), {}, {}, {}, {}, {}};
  if (!theirs.rounds.empty()) {
    figure.peer = kEngineNames[engine];
    figure.theirs = spread(theirs.rounds);
    figure.ratio = spread(ratio(ours.rounds, theirs.rounds));
  }
  return figure;
}

// The whole set as if it were one drive: each round's mean over its scenes, each scene counted once.
SceneTimes whole_set(const std::vector<SceneTimes>& all) {
  SceneTimes set;
  for (std::size_t e = 0; e < kEngines; ++e) {
    for (std::size_t r = 0; r < all.front()[e].rounds.size(); ++r) {
      double sum = 0;
      for (const SceneTimes& one : all) sum += one[e].rounds.values()[r];
      set[e].rounds.add(sum / static_cast<double>(all.size()));
    }
    for (const SceneTimes& one : all) {
      for (const double us : one[e].steps.values()) set[e].steps.add(us);
    }
  }
  return set;
}

void report_set(const SceneTimes& set, std::size_t scenes, Report& report) {
  const std::string what = "mean of a step, all " + std::to_string(scenes) + " scenes";
  for (int e = 1; e < kEngines; ++e) {
    const StepTimes& theirs = set[static_cast<std::size_t>(e)];
    if (theirs.rounds.empty() && e > 1) continue;
    Figure figure = beside(what, set[0], theirs, e);
    if (e == 1 && !theirs.rounds.empty())
      set_goal(figure, "ratio <= 0.5", figure.ratio["value"].get<double>() <= 0.5);
    report.add(figure);
  }
}

}  // namespace

void measure_plant_speed(const PlantSettings& settings, Report& report) {
  std::vector<SceneTimes> all;
  double slowest = 0;
  const char* slowest_scene = "";
  Json rows = Json::array();
  for (const BenchScene* scene : chosen_scenes(settings)) {
    tell(std::string("speed: ") + scene->name);
    SceneTimes& times = all.emplace_back();
    for (int i = 0; i < settings.rounds; ++i) time_round(*scene, times);
    if (times[0].rounds.median() > slowest) {
      slowest = times[0].rounds.median();
      slowest_scene = scene->name;
    }
    for (int e = 1; e < kEngines; ++e) {
      const StepTimes& theirs = times[static_cast<std::size_t>(e)];
      if (!theirs.rounds.empty() || e == 1)
        report.add(beside(std::string("mean of a step, ") + scene->name, times[0], theirs, e));
    }
    for (std::size_t e = 0; e < kEngines; ++e) {
      const StepTimes& one = times[e];
      if (one.steps.empty()) continue;
      rows.push_back({scene->name, kEngineNames[e], one.steps.size(), one.steps.median(),
                      one.steps.quantile(0.99), one.steps.high(), one.rounds.median(),
                      kStep_s * 1e6 / one.rounds.median()});
    }
  }
  const SceneTimes set = whole_set(all);
  if (all.size() > 1) report_set(set, all.size(), report);
  const auto real_time = [&](const std::string& what, std::size_t n, double us) {
    Figure figure{
        kGroup, "real-time factor at 1 ms, " + what, "times", n, spread(kStep_s * 1e6 / us), {}, {}, {}, {},
        {}};
    set_goal(figure, ">= 100", kStep_s * 1e6 / us >= 100);
    report.add(figure);
  };
  if (all.size() > 1) real_time("all scenes", all.size(), set[0].rounds.median());
  real_time(std::string(all.size() > 1 ? "slowest: " : "") + slowest_scene, 1, slowest);
  report.add_table(
      kGroup, {"scene", "engine", "steps", "median us", "p99 us", "max us", "mean us", "real-time factor"},
      rows);
  report.note(
      kGroup,
      "Steps of 1 ms. Slices of 250 steps of ours, QuickStep and Step alternate along the same drive; "
      "means are CPU time of the measuring thread, and a ratio is that of the means of one round; "
      "median, p99 and max are single steps by the clock, with what other programs took meanwhile. A "
      "step of ODE is collision, solving and clearing its joints.");
  if (has_ode()) {
    report.note(
        kGroup,
        "Both have the same masses, outline, obstacles, friction and surface speeds. In ours flippers "
        "are joints with servos and friction is a cone; in ODE the vehicle is one rigid body, friction "
        "a pyramid along the direction of motion, the vehicle 11 boxes and 12 cylinders.");
  }
}

}  // namespace sortie::bench
