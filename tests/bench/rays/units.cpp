// SPDX-License-Identifier: BSD-3-Clause
// What a work unit takes on the nine hard maps, and whether budgets are kept there.
#include <algorithm>
#include <iostream>

#include "rt/posix/clock.hpp"
#include "tests/bench/rays/ray_parts.hpp"
#include "tests/planner/ray_scenes.hpp"

namespace sortie::bench {

void measure_ray_units(const RaySettings& settings, Report& report) {
  constexpr std::uint64_t kBudget = 2'000'000;
  Json rows = Json::array();
  double least = 1e9;
  double most = 0;
  bool kept = true;
  for (std::size_t number = 0; number < tests::hard_maps().size(); ++number) {
    std::cerr << "rays: " << tests::hard_maps()[number] << "\n";
    planner::RaySchedulerConfig config;
    tests::RayMap map;
    tests::make_hard_map(map, number);
    tests::OwnedScheduler owned(config);
    const auto poses = tests::poses_ahead(map.map.view(), config.positions, 4.0);
    double best = 1e9;
    for (int round = 0; round < std::max(3, settings.rounds); ++round) {
      (void)owned.scheduler.begin(map.map.view(), poses);
      const auto before = rt::posix::thread_cpu_now();
      const std::uint64_t spent = owned.scheduler.step(kBudget);
      best = std::min(best,
                      static_cast<double>(rt::posix::thread_cpu_now() - before) / static_cast<double>(spent));
      kept = kept && spent <= kBudget;
    }
    least = std::min(least, best);
    most = std::max(most, best);
    const planner::RayPlan& plan = owned.scheduler.plan();
    rows.push_back({tests::hard_maps()[number], best, plan.units, plan.worth, plan.traced, plan.evaluations,
                    plan.table_used});
  }
  report.add_table(
      "hard maps",
      {"map", "ns a unit", "units of 2,000,000", "worth, nats", "traced", "evaluations", "lines"}, rows);
  Figure spread_of_units{
      "hard maps", "dearest unit over cheapest", "times", 9, spread(most / least), {}, {}, {}, {}, {}};
  set_goal(spread_of_units, "<= 3", most / least <= 3);
  report.add(spread_of_units);
  Figure budgets{"hard maps", "budgets kept", "", 9, spread(kept ? 1 : 0), {}, {}, {}, {}, {}};
  set_goal(budgets, "all", kept);
  report.add(budgets);
}

}  // namespace sortie::bench
