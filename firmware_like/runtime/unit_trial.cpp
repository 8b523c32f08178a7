// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/runtime/unit_trial.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mapping/occupancy/occupancy.hpp"
#include "planner/ssl_choice.hpp"
#include "rt/posix/clock.hpp"

namespace sortie::firmware {

namespace {

constexpr std::uint64_t kTrialUnits = 1'000'000;

// Walls of a cell at every eighth place along two axes, with gaps; free between them.
void scatter_walls(mapping::OccupancyMap& map) {
  const std::int32_t(&size)[3] = map.config().size;
  for (std::int32_t z = 0; z < size[2]; ++z) {
    for (std::int32_t y = 0; y < size[1]; ++y) {
      for (std::int32_t x = 0; x < size[0]; ++x) {
        const bool wall = (x % 8 == 3 && y % 5 != 0) || (y % 8 == 3 && x % 5 != 0);
        map.set(x, y, z, wall ? 6 : -9);
      }
    }
  }
}

constexpr int kTimes = 3;

double time_plan(planner::SslChoice& choice, const mapping::OccupancyMap& map, std::uint32_t positions) {
  const std::vector<mapping::SensorPose> poses(positions);
  if (choice.begin(map.view(), poses, planner::RayScheduler::kNothingPassed) != Status::ok) return 0.0;
  const rt::Nanoseconds before = rt::posix::monotonic_now();
  const std::uint64_t spent = choice.step(kTrialUnits);
  const rt::Nanoseconds after = rt::posix::monotonic_now();
  return spent == 0 ? 0.0 : static_cast<double>(after - before) / static_cast<double>(spent);
}

double shortest_plan(planner::SslChoice& choice, const mapping::OccupancyMap& map, std::uint32_t positions) {
  double shortest = time_plan(choice, map, positions);
  for (int i = 1; i < kTimes; ++i) shortest = std::min(shortest, time_plan(choice, map, positions));
  return shortest;
}

}  // namespace

UnitTrial try_ray_units(const planner::SslChoiceConfig& config, const mapping::OccupancyConfig& map_config) {
  std::vector<std::int8_t> cells(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(map_config)));
  std::vector<std::byte> memory(static_cast<std::size_t>(planner::SslChoice::memory_bytes(config)));
  mapping::OccupancyMap map(map_config, cells);
  planner::SslChoice choice(config, memory);
  const std::uint32_t positions = config.scheduler.positions;
  UnitTrial trial;
  static_cast<void>(time_plan(choice, map, positions));  // warms up
  trial.ns_per_unit = shortest_plan(choice, map, positions);
  scatter_walls(map);
  trial.ns_per_unit = std::max(trial.ns_per_unit, shortest_plan(choice, map, positions));
  return trial;
}

std::uint32_t units_that_fit(const UnitTrial& trial, double share) {
  const double fit = std::floor(1e3 * share * trial.budget_us / trial.ns_per_unit);
  return static_cast<std::uint32_t>(std::clamp(fit, 1.0, 4e9));
}

std::string unit_warning(const UnitTrial& trial) {
  const double takes_us = 1e-3 * trial.ns_per_unit * trial.units;
  if (trial.task.empty() || takes_us <= trial.budget_us) return {};
  return "calibration: " + std::to_string(trial.units) + " units of task " + trial.task + " take about " +
         std::to_string(std::llround(takes_us)) + " us here, but its budget is " +
         std::to_string(std::llround(trial.budget_us)) + " us; cure: --set tasks." + trial.task +
         ".units=" + std::to_string(units_that_fit(trial, 1.0)) + ", or a larger tasks." + trial.task +
         ".budget_us";
}

}  // namespace sortie::firmware
