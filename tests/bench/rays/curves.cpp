// SPDX-License-Identifier: BSD-3-Clause
// Worth against run time on streets at the paper's setting. The literal Algorithm 4 (corrected, on a stored
// sparse matrix in double, building included) is the peer; all worths are exact sums in double over its rays.
#include <algorithm>
#include <iostream>
#include <random>

#include "rt/archive.hpp"
#include "rt/posix/clock.hpp"
#include "tests/bench/rays/ray_parts.hpp"
#include "tests/planner/ray_reference.hpp"
#include "tests/planner/ray_scenes.hpp"

namespace sortie::bench {

namespace {

constexpr double kBudgets_ms[] = {1, 2, 5, 10, 50};
constexpr double kGoals[] = {0.55, 0.80, 0.95, 0.99, 0.998};

double cpu_ms() { return static_cast<double>(rt::posix::thread_cpu_now()) * 1e-6; }

// One task, and what the peer makes of it.
struct RayBench {
  RayBench(std::uint64_t seed, bool guessed, std::uint32_t positions) : street(map.map.config().size, seed) {
    config.positions = positions;
    tests::make_street(map, seed, config.sensor, guessed);
    for (std::uint32_t p = 0; p < positions; ++p)
      poses.push_back(tests::street_pose(street, map.map.view(), 4.0 * p));
    name = std::string(guessed ? "street, guessed" : "street, measured") + " " + std::to_string(seed) +
           ", L = " + std::to_string(positions);
  }
  // One position further: the first position's rays of a plan were fired and entered.
  void go_on(const planner::RayScheduler& scheduler) {
    const mapping::SensorPose from = poses.front();
    for (const std::uint16_t ray : scheduler.rays(0)) {
      rt::Vector3 to;
      const bool hit = tests::cast_ray(street, map.map.view(), from.p_world_sensor_m,
                                       tests::ray_direction(config.sensor, ray), config.sensor.range_m, to);
      (void)map.map.update_ray(from.p_world_sensor_m, to, hit);
    }
    const double forward = 4.0 * static_cast<double>(poses.size());
    poses.erase(poses.begin());
    poses.push_back(tests::street_pose(street, map.map.view(), forward));
    name += ", after the plan before";
  }

  planner::RaySchedulerConfig config;
  tests::RayMap map;
  tests::Street street;
  std::vector<mapping::SensorPose> poses;
  std::string name;
};

// A moment of our run.
struct RayMoment {
  double ms{};
  double ratio{};
  planner::RayPlan plan;
};

// Runs the scheduler to its end in slices; moments at which the plan was another one. `passed`: from the plan
// that it holds.
std::vector<RayMoment> run_ours(tests::OwnedScheduler& owned, const RayBench& bench,
                                const tests::RayMatrix& matrix, double best,
                                std::uint32_t passed = planner::RayScheduler::kNothingPassed) {
  std::vector<RayMoment> moments;
  double ms = 0;
  std::uint64_t digest = 0;
  double before = cpu_ms();
  (void)owned.scheduler.begin(bench.map.map.view(), bench.poses, passed);
  ms += cpu_ms() - before;
  while (true) {
    if (owned.scheduler.plan().digest != digest || owned.scheduler.done()) {
      digest = owned.scheduler.plan().digest;
      moments.push_back(
          {ms, matrix.worth(tests::chosen_rows(owned.scheduler)) / best, owned.scheduler.plan()});
    }
    if (owned.scheduler.done()) return moments;
    before = cpu_ms();
    (void)owned.scheduler.step(10'000);
    ms += cpu_ms() - before;
  }
}

std::vector<RayMoment> run_cold(const RayBench& bench, const planner::RaySchedulerConfig& config,
                                const tests::RayMatrix& matrix, double best) {
  tests::OwnedScheduler owned(config);
  return run_ours(owned, bench, matrix, best);
}

double ratio_at(const std::vector<RayMoment>& moments, double ms) {
  double ratio = 0;
  for (const RayMoment& moment : moments) {
    if (moment.ms <= ms) ratio = moment.ratio;
  }
  return ratio;
}

double time_to(const std::vector<RayMoment>& moments, double ratio) {
  for (const RayMoment& moment : moments) {
    if (moment.ratio >= ratio) return moment.ms;
  }
  return 0;
}

// Plans that anybody could make.
std::vector<std::size_t> simple_rows(const RayBench& bench, bool random) {
  std::mt19937_64 draw(1);
  std::vector<std::size_t> rows;
  const std::uint32_t all = bench.config.sensor.rays();
  for (std::uint32_t p = 0; p < bench.config.positions; ++p) {
    std::vector<bool> taken(all);
    for (std::uint32_t i = 0; i < bench.config.rays;) {
      std::size_t ray = draw() % all;
      if (!random) ray = (i / 20 * 12 + 6) * bench.config.sensor.columns + i % 20 * 8 + 4;  // 20 x 10
      if (taken[ray]) continue;
      taken[ray] = true;
      rows.push_back(p * all + ray);
      ++i;
    }
  }
  return rows;
}

const char* stage_name(const RayMoment& moment) {
  const char* const stages[] = {"ours: seed", "ours: positions", "ours: joint", "ours: exact"};
  return stages[static_cast<int>(moment.plan.stage)];
}

void add_moments(const RayBench& bench, const std::vector<RayMoment>& moments, Json& rows) {
  for (const RayMoment& moment : moments)
    rows.push_back({bench.name, stage_name(moment), moment.ms, moment.ratio,
                    moment.plan.evaluations + moment.plan.traced,
                    moment.plan.certificate > 0 ? Json(moment.plan.certificate) : Json("not known yet")});
}

// Worth at the asked budgets.
void add_budgets(const RayBench& bench, const std::vector<RayMoment>& moments, Json& budgets) {
  for (std::size_t i = 0; i < std::size(kBudgets_ms); ++i) {
    const double at = ratio_at(moments, kBudgets_ms[i]);
    const double goal = bench.config.positions > 1 ? kGoals[i] : i == 0 ? 0.99 : 0.999;
    budgets.push_back({bench.name, kBudgets_ms[i], at, goal, at >= goal ? "met" : "MISSED"});
  }
}

void measure_one(const RayBench& bench, const RaySettings& settings, Report& report, Json& rows,
                 Json& budgets, Json& curves) {
  std::cerr << "rays: " << bench.name << "\n";
  planner::RaySchedulerConfig exact = bench.config;
  exact.position_first = false;
  exact.joint = false;
  exact.certify = false;
  planner::RaySchedulerConfig joint = bench.config;
  joint.position_first = false;
  joint.exact = false;
  tests::OwnedScheduler owned(bench.config);
  (void)owned.scheduler.begin(bench.map.map.view(), bench.poses);
  Rounds literal_ms;
  Rounds exact_ms;
  Rounds joint_ms;
  Rounds full_ms;
  std::vector<RayMoment> moments;
  std::vector<RayMoment> exact_moments;
  std::vector<RayMoment> joint_moments;
  double best = 1;
  double selection_ms = 0;
  tests::RayMatrix matrix;
  tests::ReferencePlan literal;
  for (int round = 0; round < settings.rounds; ++round) {
    double before = cpu_ms();
    matrix = tests::build_ray_matrix(owned.scheduler, bench.map.map.view());
    const double built = cpu_ms();
    literal = tests::prioritized_greedy(matrix, bench.config.rays, false);
    selection_ms = cpu_ms() - built;
    literal_ms.add(cpu_ms() - before);
    best = matrix.worth(literal.chosen);
    exact_moments = run_cold(bench, exact, matrix, best);
    exact_ms.add(exact_moments.back().ms);
    joint_moments = run_cold(bench, joint, matrix, best);
    joint_ms.add(joint_moments.back().ms);
    const std::vector<RayMoment> now = run_cold(bench, bench.config, matrix, best);
    if (moments.empty() || now.back().ms < moments.back().ms) moments = now;
    full_ms.add(time_to(now, 0.995) > 0 ? time_to(now, 0.995) : now.back().ms);
  }
  const auto figure = [&](const char* what, const Rounds& own, double least, double ratio, double needed) {
    Figure f{"speed",
             std::string(what) + ", " + bench.name,
             "ms",
             own.size(),
             spread(own),
             "literal Alg. 4",
             spread(literal_ms),
             spread(sortie::bench::ratio(own, literal_ms)),
             {},
             {}};
    set_goal(f, "1/" + std::to_string(static_cast<int>(least)) + " at " + std::to_string(needed).substr(0, 5),
             f.ratio["value"].get<double>() <= 1 / least && ratio >= needed);
    report.add(f);
  };
  if (bench.config.positions > 1) {
    figure("all stages to 0.995", full_ms, 15, moments.back().ratio, 0.995);
    figure("joint stage alone", joint_ms, 15, joint_moments.back().ratio, 0.995);
    figure("exact stage alone", exact_ms, 6, exact_moments.back().ratio, 0.998);
  } else {
    report.add({"speed",
                "exact stage alone, " + bench.name,
                "ms",
                exact_ms.size(),
                spread(exact_ms),
                "literal Alg. 4",
                spread(literal_ms),
                spread(sortie::bench::ratio(exact_ms, literal_ms)),
                {},
                {}});
  }
  const auto row = [&](const char* planner, double ms, double ratio, std::uint64_t evaluations,
                       const Json& certificate) {
    rows.push_back({bench.name, planner, ms, ratio, evaluations, certificate});
    curves.push_back({{"task", bench.name}, {"planner", planner}, {"ms", ms}, {"ratio", ratio}});
  };
  const std::uint64_t none = 0;
  row("literal Alg. 4, corrected", literal_ms.median(), 1.0, literal.evaluations, "");
  double before = cpu_ms();
  const tests::ReferencePlan printed = tests::prioritized_greedy(matrix, bench.config.rays, true);
  row("literal Alg. 4, as printed", literal_ms.median() - selection_ms + cpu_ms() - before,
      matrix.worth(printed.chosen) / best, printed.evaluations, "");
  if (bench.config.positions == 1) {
    before = cpu_ms();
    const tests::ReferencePlan naive = tests::naive_greedy(matrix, bench.config.rays);
    row("naive greedy, Alg. 3", literal_ms.median() - selection_ms + cpu_ms() - before,
        matrix.worth(naive.chosen) / best, naive.evaluations, "");
  }
  row("random", 0, matrix.worth(simple_rows(bench, true)) / best, none, "");
  row("grid 20 x 10", 0, matrix.worth(simple_rows(bench, false)) / best, none, "");
  row("ours, exact stage alone", exact_ms.median(), exact_moments.back().ratio,
      exact_moments.back().plan.evaluations + exact_moments.back().plan.traced, "");
  row("ours, joint stage alone", joint_ms.median(), joint_moments.back().ratio,
      joint_moments.back().plan.evaluations + joint_moments.back().plan.traced, "");
  add_moments(bench, moments, rows);
  for (const RayMoment& moment : moments)
    curves.push_back(
        {{"task", bench.name}, {"planner", stage_name(moment)}, {"ms", moment.ms}, {"ratio", moment.ratio}});
  add_budgets(bench, moments, budgets);
}

// The next task, with the previous plan as seed: what a robot under way has.
void measure_next(RayBench& bench, const RaySettings& settings, Json& rows, Json& budgets) {
  planner::RaySchedulerConfig config = bench.config;
  config.exact = false;
  std::vector<std::uint8_t> before;
  {
    tests::OwnedScheduler owned(config);
    (void)owned.scheduler.begin(bench.map.map.view(), bench.poses);
    while (!owned.scheduler.done()) (void)owned.scheduler.step(1'000'000);
    bench.go_on(owned.scheduler);
    rt::Archive measure = rt::Archive::measuring();
    owned.scheduler.archive(measure);
    before.resize(static_cast<std::size_t>(measure.bytes()));
    rt::Archive write = rt::Archive::writing(before);
    owned.scheduler.archive(write);
  }
  std::cerr << "rays: " << bench.name << "\n";
  tests::OwnedScheduler shape(config);
  (void)shape.scheduler.begin(bench.map.map.view(), bench.poses);
  const tests::RayMatrix matrix = tests::build_ray_matrix(shape.scheduler, bench.map.map.view());
  const double best = matrix.worth(tests::prioritized_greedy(matrix, config.rays, false).chosen);
  std::vector<RayMoment> moments;
  for (int round = 0; round < settings.rounds; ++round) {
    tests::OwnedScheduler owned(bench.config);
    rt::Archive read = rt::Archive::reading(before);
    owned.scheduler.archive(read);
    const std::vector<RayMoment> now = run_ours(owned, bench, matrix, best, 1);
    if (moments.empty() || now.back().ms < moments.back().ms) moments = now;
  }
  add_moments(bench, moments, rows);
  add_budgets(bench, moments, budgets);
}

}  // namespace

void measure_ray_curves(const RaySettings& settings, Report& report) {
  Json rows = Json::array();
  Json budgets = Json::array();
  Json curves = Json::array();
  for (const bool guessed : {true, false}) {
    for (int seed = 1; seed <= settings.seeds; ++seed) {
      for (const std::uint32_t positions : {1u, 5u}) {
        RayBench bench(static_cast<std::uint64_t>(seed), guessed, positions);
        measure_one(bench, settings, report, rows, budgets, curves);
        if (positions > 1) measure_next(bench, settings, rows, budgets);
      }
    }
  }
  report.add_table("worth over run time",
                   {"task", "planner", "ms", "worth / greedy", "evaluations", "certificate"}, rows);
  report.add_table("budgets", {"task", "budget, ms", "worth / greedy", "goal", "verdict"}, budgets);
  report.root()["ray_curves"] = curves;
}

}  // namespace sortie::bench
