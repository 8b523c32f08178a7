// SPDX-License-Identifier: BSD-3-Clause
// Small tasks for the ray scheduler, so small that all plans can be tried, and plain greedy on the
// scheduler's own model.
#pragma once

#include <algorithm>
#include <random>
#include <vector>

#include "tests/planner/ray_reference.hpp"
#include "tests/planner/ray_scenes.hpp"

namespace sortie::tests {

/// How large a small task is.
struct SmallSize {
  std::uint32_t columns{12};
  std::uint32_t rows{8};
  std::int32_t cells{20};  ///< of the map along x and y
  std::uint32_t rays{5};
  std::uint32_t positions{2};
};

/// A random map and a scheduler for it. Cells are of few kinds, so that ties are common; some maps hold
/// unknown cells.
struct SmallTask {
  static mapping::OccupancyConfig map_config(const SmallSize& size) {
    mapping::OccupancyConfig config;
    config.size[0] = size.cells;
    config.size[1] = size.cells;
    config.size[2] = std::max(2, size.cells / 3);
    config.anchor[0] = 0.5;
    return config;
  }
  static planner::RaySchedulerConfig scheduler_config(const SmallSize& size, std::uint64_t seed) {
    planner::RaySchedulerConfig config;
    config.sensor = {size.columns, size.rows, 2.0, 1.0, 0.25 * size.cells};
    config.rays = size.rays;
    config.positions = size.positions;
    config.map_cells = 1u << 12;
    config.model.unknown = seed % 3 == 0 ? planner::UnknownSpace::stop : planner::UnknownSpace::prior;
    config.coarse_log2 = 2;
    return config;
  }

  SmallTask(const SmallSize& size, std::uint64_t seed)
      : SmallTask(size, seed, scheduler_config(size, seed)) {}
  SmallTask(const SmallSize& size, std::uint64_t seed, const planner::RaySchedulerConfig& config)
      : map(map_config(size)), owned(config) {
    std::mt19937_64 random(seed);
    const int kinds = 1 + static_cast<int>(random() % 6);
    int codes[6];
    for (int& code : codes) code = static_cast<int>(random() % 255) - 127;
    for (std::int8_t& cell : map.cells) {
      const auto kind = static_cast<int>(random() % static_cast<std::uint64_t>(kinds + 1));
      cell = kind == kinds ? mapping::kUnknownCell : static_cast<std::int8_t>(codes[kind] / (kind + 1));
    }
    for (std::uint32_t p = 0; p < size.positions; ++p) {
      const double x = 1e-3 * static_cast<double>(random() % 1500) - 0.75;
      const double y = 1e-3 * static_cast<double>(random() % 1500) - 0.75;
      const double yaw = 1e-3 * static_cast<double>(random() % 6283);
      poses.push_back({{x, y, 0.05}, rt::exp_rotation({0, 0, yaw})});
    }
  }
  planner::RayScheduler& begin() {
    (void)owned.scheduler.begin(map.map.view(), poses);
    return owned.scheduler;
  }
  planner::RayScheduler& finish() {
    (void)begin();
    while (!owned.scheduler.done()) (void)owned.scheduler.step(1'000'000);
    return owned.scheduler;
  }

  RayMap map;
  OwnedScheduler owned;
  std::vector<mapping::SensorPose> poses;
};

/// Plain greedy: every ray is worth what the model says, computed anew for each choice with an array of all
/// cells; the greatest worth as a float wins, ties go to the lower position and number.
inline std::vector<std::size_t> naive_on_the_model(const planner::RayScheduler& scheduler,
                                                   const mapping::OccupancyView& map) {
  const std::uint32_t rays = scheduler.config().sensor.rays();
  const planner::RayModel& model = scheduler.model();
  std::vector<float> left(static_cast<std::size_t>(map.cell_count()), 1.0f);
  std::vector<std::uint32_t> room(scheduler.plan().positions, scheduler.plan().rays);
  std::vector<bool> taken(std::size_t{rays} * room.size());
  std::vector<std::size_t> chosen;
  std::vector<std::pair<std::uint32_t, double>> passed;
  const auto worth_of = [&](std::size_t j, bool keep) {
    mapping::VoxelWalk walk =
        scheduler.walk(static_cast<std::uint32_t>(j / rays), static_cast<std::uint32_t>(j % rays));
    double visible = 1;
    double entropy = 0;
    double worth = 0;
    if (keep) passed.clear();
    do {
      const std::uint32_t code = mapping::cell_code(map.cells[walk.index]);
      const double here = model.probability(code) * visible;
      entropy += model.entropy(code) * static_cast<double>(left[walk.index]);
      worth += here * entropy;
      if (keep) passed.push_back({walk.index, here});
      visible *= model.passes(code);
    } while (visible >= model.config().least_visible && walk.step());
    return static_cast<float>(worth);
  };
  for (;;) {
    float best = 0;
    std::size_t which = taken.size();
    for (std::size_t j = 0; j < taken.size(); ++j) {
      if (taken[j] || room[j / rays] == 0) continue;
      const float worth = worth_of(j, false);
      if (worth > best) {
        best = worth;
        which = j;
      }
    }
    if (which == taken.size()) return chosen;
    (void)worth_of(which, true);
    double shown = 0;
    for (std::size_t i = passed.size(); i-- > 0;) {
      shown += passed[i].second;
      float& cell = left[passed[i].first];
      if (shown > 1e-8) cell = static_cast<float>(static_cast<double>(cell) * (1.0 - shown));
    }
    taken[which] = true;
    --room[which / rays];
    chosen.push_back(which);
  }
}

/// What rays are worth in double, with rays cut where the scheduler cuts them: each share is the sum of what
/// ends behind a cell. `left` is scratch, an entry a cell of the map.
inline double cut_worth(const planner::RayScheduler& scheduler, const mapping::OccupancyView& map,
                        std::vector<double>& left, const std::vector<std::size_t>& rows) {
  const planner::RayModel& model = scheduler.model();
  std::fill(left.begin(), left.end(), 1.0);
  std::vector<std::pair<std::uint32_t, double>> passed;
  double worth = 0;
  for (const std::size_t row : rows) {
    const std::uint32_t rays = scheduler.config().sensor.rays();
    mapping::VoxelWalk walk =
        scheduler.walk(static_cast<std::uint32_t>(row / rays), static_cast<std::uint32_t>(row % rays));
    passed.clear();
    double visible = 1;
    do {
      const std::uint32_t code = mapping::cell_code(map.cells[walk.index]);
      passed.push_back({walk.index, model.probability(code) * visible});
      visible *= model.passes(code);
    } while (visible >= model.config().least_visible && walk.step());
    double shown = 0;
    for (std::size_t i = passed.size(); i-- > 0;) {
      shown += passed[i].second;
      double& cell = left[passed[i].first];
      worth += model.entropy(mapping::cell_code(map.cells[passed[i].first])) * cell * shown;
      cell *= 1 - shown;
    }
  }
  return worth;
}

inline double cut_worth(const planner::RayScheduler& scheduler, const mapping::OccupancyView& map,
                        std::vector<double>& left) {
  return cut_worth(scheduler, map, left, chosen_rows(scheduler));
}

/// True when a plan's first choices at each position are those of a sequence.
inline bool begins_with(const planner::RayScheduler& scheduler, const std::vector<std::size_t>& sequence) {
  const std::uint32_t rays = scheduler.config().sensor.rays();
  std::vector<std::uint32_t> count(scheduler.plan().positions);
  for (const std::size_t j : sequence) {
    const auto p = static_cast<std::uint32_t>(j / rays);
    if (scheduler.rays(p)[count[p]++] != j % rays) return false;
  }
  return true;
}

/// True when every position has min(K, N) different rays.
inline bool is_valid_plan(const planner::RayScheduler& scheduler) {
  const planner::RaySchedulerConfig& config = scheduler.config();
  for (std::uint32_t p = 0; p < scheduler.plan().positions; ++p) {
    std::vector<std::uint16_t> rays(scheduler.rays(p).begin(), scheduler.rays(p).end());
    std::sort(rays.begin(), rays.end());
    if (rays.size() != std::min(config.rays, config.sensor.rays())) return false;
    if (std::adjacent_find(rays.begin(), rays.end()) != rays.end()) return false;
    if (!rays.empty() && rays.back() >= config.sensor.rays()) return false;
  }
  return scheduler.rays(scheduler.plan().positions).empty();
}

}  // namespace sortie::tests
