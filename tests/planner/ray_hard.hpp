// SPDX-License-Identifier: BSD-3-Clause
// The ray scheduler over the nine hard maps with many budgets.
#pragma once

#include "rt/digest.hpp"
#include "tests/planner/ray_small.hpp"

namespace sortie::tests {

/// Sizes of a sweep.
struct HardTask {
  mapping::OccupancyConfig map;
  planner::RaySchedulerConfig config;
};

/// Small enough for a sanitizer.
inline HardTask small_hard_task() {
  HardTask task;
  task.map.size[0] = 64;
  task.map.size[1] = 64;
  task.map.size[2] = 16;
  task.config.sensor = {24, 16, 2.0943951023931953, 1.5707963267948966, 8.0};
  task.config.rays = 12;
  task.config.positions = 3;
  task.config.map_cells = 64 * 64 * 16;
  task.config.explored = 150;
  task.config.coarse_log2 = 2;
  return task;
}

/// What a sweep found; all but `rises` and `full` are faults.
struct HardResult {
  int invalid{};  ///< plans with too few rays, or the same twice
  int beyond{};   ///< budgets that were not kept
  int falls{};    ///< a greater budget, and a plan that is worth less
  int rises{};
  int full{};  ///< tasks whose table was full
};

/// Rising budgets on each hard map, each on a scheduler that starts anew; worths by the exact sum in double,
/// with rays cut where the scheduler cuts them.
inline HardResult sweep_hard_maps(const HardTask& task, int budgets) {
  HardResult result;
  for (std::size_t number = 0; number < hard_maps().size(); ++number) {
    RayMap map(task.map);
    make_hard_map(map, number);
    const mapping::OccupancyView view = map.map.view();
    const auto poses = poses_ahead(view, task.config.positions, 1.0);
    OwnedScheduler owned(task.config);
    std::vector<double> left(static_cast<std::size_t>(view.cell_count()));
    double before = 0;
    std::uint64_t budget = 0;
    for (int i = 0; i < budgets; ++i) {
      (void)owned.scheduler.begin(view, poses);
      const std::uint64_t spent = owned.scheduler.step(budget);
      result.beyond += spent > budget || owned.scheduler.plan().units != spent ? 1 : 0;
      result.invalid += is_valid_plan(owned.scheduler) ? 0 : 1;
      const double worth = cut_worth(owned.scheduler, view, left);
      result.falls += worth < before * (1 - 1e-9) ? 1 : 0;
      result.rises += worth > before ? 1 : 0;
      result.falls += owned.scheduler.plan().worth > worth * (1 + 1e-5) + 1e-12 ? 1 : 0;
      before = worth;
      budget = budget < 2000 ? budget + 1000 : budget * 3 / 2;
    }
    result.full += owned.scheduler.plan().table_full ? 1 : 0;
  }
  return result;
}

}  // namespace sortie::tests
