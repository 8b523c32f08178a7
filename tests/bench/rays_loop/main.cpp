// SPDX-License-Identifier: BSD-3-Clause
// sortie-bench-rays-loop: what the map gains in a closed loop, policy beside policy, and prints one JSON
// object. `sortie bench rays --only loop` runs it and shows the tables.
#include <cstdio>
#include <iostream>
#include <map>
#include <stdexcept>

#include "tests/bench/rays_loop/interval.hpp"
#include "tests/bench/rays_loop/loop.hpp"
#include "tests/bench/report/arguments.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

namespace {

std::vector<LoopArm> loop_arms() {
  using planner::SslPolicy;
  std::vector<LoopArm> arms(6);
  arms[0].name = "random";
  arms[0].choice.policy = SslPolicy::random;
  arms[1].name = "grid";
  arms[1].choice.policy = SslPolicy::grid;
  arms[2].name = "stride";
  arms[2].choice.policy = SslPolicy::stride;
  arms[3].name = "scheduled, L = 1";
  arms[3].choice.scheduler.positions = 1;
  arms[4].name = "scheduled, L = 5";
  arms[5].name = "scheduled, L = 1, stop at unknown";
  arms[5].choice.scheduler.positions = 1;
  arms[5].choice.scheduler.model.unknown = planner::UnknownSpace::stop;
  return arms;
}

// Differences of one arm to another, in percent of the other.
struct Differences {
  std::vector<double> loss;   // how much lower
  std::vector<double> found;  // how many more
};

std::string words(const std::vector<double>& differences) {
  const Interval interval = paired_interval(differences);
  char text[64];
  std::snprintf(text, sizeof text, "%+.1f (%+.1f .. %+.1f)", interval.mean, interval.low(), interval.high());
  return text;
}

double mean_of(const std::vector<double>& values) { return paired_interval(values).mean; }

// All seeds of one scene, arm by arm: the loop's end, and the course of the loss.
struct SceneResults {
  std::vector<std::vector<LoopResult>> by_arm;
};

SceneResults measure_scene(const LoopScene& scene, const std::vector<LoopArm>& arms, const LoopSize& size,
                           int seeds) {
  SceneResults results;
  results.by_arm.resize(arms.size());
  for (int seed = 1; seed <= seeds; ++seed) {
    const LoopWorld world = scene.make(static_cast<std::uint64_t>(seed));
    const std::vector<std::uint8_t> truth = loop_truth(world, size);
    for (std::size_t a = 0; a < arms.size(); ++a)
      results.by_arm[a].push_back(run_loop(world, truth, arms[a], size, static_cast<std::uint64_t>(seed)));
    std::cerr << scene.name << " " << seed << "/" << seeds << "\n";
  }
  return results;
}

Differences differences(const std::vector<LoopResult>& arm, const std::vector<LoopResult>& base) {
  Differences d;
  for (std::size_t s = 0; s < arm.size(); ++s) {
    d.loss.push_back(100.0 * (1.0 - arm[s].loss.back() / base[s].loss.back()));
    d.found.push_back(100.0 * (arm[s].found.back() / base[s].found.back() - 1.0));
  }
  return d;
}

void append(Differences& to, const Differences& from) {
  to.loss.insert(to.loss.end(), from.loss.begin(), from.loss.end());
  to.found.insert(to.found.end(), from.found.begin(), from.found.end());
}

Json row_of(const std::string& name, const Differences& random, const Differences& grid) {
  return {name, words(random.loss), words(grid.loss), words(random.found), words(grid.found)};
}

void add_scene(const std::string& name, const std::vector<LoopArm>& arms, const SceneResults& results,
               Report& report) {
  Json rows = Json::array();
  for (std::size_t a = 0; a < arms.size(); ++a) {
    std::vector<double> loss;
    std::vector<double> found;
    int unplanned = 0;
    Json curve = Json::array();
    for (const LoopResult& one : results.by_arm[a]) {
      loss.push_back(one.loss.back());
      found.push_back(one.found.back());
      unplanned += one.unplanned;
    }
    for (std::size_t frame = 0; frame < results.by_arm[a][0].loss.size(); ++frame) {
      std::vector<double> losses;
      for (const LoopResult& one : results.by_arm[a]) losses.push_back(one.loss[frame]);
      curve.push_back(mean_of(losses));
    }
    report.root()["loop_curves"].push_back({{"scene", name}, {"policy", arms[a].name}, {"loss", curve}});
    const Differences to_random = differences(results.by_arm[a], results.by_arm[0]);
    const Differences to_grid = differences(results.by_arm[a], results.by_arm[1]);
    Json row = {arms[a].name, mean_of(loss), mean_of(found), unplanned};
    for (const std::vector<double>* d : {&to_random.loss, &to_grid.loss, &to_random.found, &to_grid.found})
      row.push_back(words(*d));
    rows.push_back(row);
  }
  report.add_table(name,
                   {"policy", "loss", "found a ray", "without a plan", "loss lower than random, %",
                    "than grid, %", "found more than random, %", "than grid, %"},
                   rows);
}

int run(int argc, char** argv) {
  int seeds = 12;
  LoopSize size;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const char* value = ++i < argc ? argv[i] : nullptr;
    if (option == "--seeds")
      seeds = static_cast<int>(number("--seeds", value, 2, 1e3));
    else if (option == "--frames")
      size.frames = static_cast<int>(number("--frames", value, 1, 1e3));
    else
      throw std::invalid_argument("unknown option " + option);
  }
  Report report;
  Json& root = report.root();
  root["load_before"] = load_average();
  for (const char* list : {"figures", "tables", "skipped", "notes", "loop_curves"})
    root[list] = Json::array();
  root["settings"] = {{"seeds", seeds}, {"frames", size.frames}, {"rays", size.rays}};
  const std::vector<LoopArm> arms = loop_arms();
  std::vector<Differences> over_random(arms.size());
  std::vector<Differences> over_grid(arms.size());
  std::vector<std::string> missing;
  for (const LoopScene& scene : loop_scenes(missing)) {
    const SceneResults results = measure_scene(scene, arms, size, seeds);
    add_scene(scene.name, arms, results, report);
    for (std::size_t a = 0; a < arms.size(); ++a) {
      append(over_random[a], differences(results.by_arm[a], results.by_arm[0]));
      append(over_grid[a], differences(results.by_arm[a], results.by_arm[1]));
    }
  }
  for (const std::string& one : missing) report.skip("a recorded place", one);
  Json rows = Json::array();
  for (std::size_t a = 0; a < arms.size(); ++a)
    rows.push_back(row_of(arms[a].name, over_random[a], over_grid[a]));
  report.add_table(
      "all scenes",
      {"policy", "loss lower than random, %", "than grid, %", "found more than random, %", "than grid, %"},
      rows);
  // The default is the policy whose loss is surely lowest beside chance.
  std::size_t best = 0;
  for (std::size_t a = 1; a < arms.size(); ++a) {
    const double low = paired_interval(over_random[a].loss).low();
    if (low > (best == 0 ? 0.0 : paired_interval(over_random[best].loss).low())) best = a;
  }
  report.note("all scenes", "best lower bound of the loss beside random: " + arms[best].name);
  root["best_policy"] = arms[best].name;
  root["load_after"] = load_average();
  std::cout << root.dump() << std::endl;
  return 0;
}

}  // namespace

}  // namespace sortie::bench

int main(int argc, char** argv) {
  return sortie::bench::guarded_main("sortie-bench-rays-loop",
                                     [argc, argv] { return sortie::bench::run(argc, argv); });
}
