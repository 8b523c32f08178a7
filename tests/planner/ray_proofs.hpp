// SPDX-License-Identifier: BSD-3-Clause
// What is proved about the ray scheduler on small tasks, as many as a test wants.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/planner/ray_small.hpp"

namespace sortie::tests {

/// The exact stage alone.
inline planner::RaySchedulerConfig exact_only(const SmallSize& size, std::uint64_t seed) {
  planner::RaySchedulerConfig config = SmallTask::scheduler_config(size, seed);
  config.position_first = false;
  config.joint = false;
  return config;
}

/// Seeds of tasks whose exact stage differs from plain greedy.
inline std::vector<std::uint64_t> lazy_unlike_naive(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> unlike;
  std::uint64_t kept = 0;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    const SmallSize size{12, 8, 20, 1 + static_cast<std::uint32_t>(seed % 7),
                         1 + static_cast<std::uint32_t>(seed % 3)};
    SmallTask task(size, seed, exact_only(size, seed));
    const planner::RayScheduler& scheduler = task.finish();
    const auto naive = naive_on_the_model(scheduler, task.map.map.view());
    bool good = is_valid_plan(scheduler);
    if (scheduler.plan().stage == planner::RayStage::exact) {
      good = good && begins_with(scheduler, naive);
    } else {
      // The seed was worth as much in the scheduler's model, which cuts rays: then it stays.
      const mapping::OccupancyView view = task.map.map.view();
      std::vector<double> left(static_cast<std::size_t>(view.cell_count()));
      good = good && cut_worth(scheduler, view, left) >= (1 - 1e-5) * cut_worth(scheduler, view, left, naive);
      ++kept;
    }
    if (!good) unlike.push_back(seed);
  }
  CHECK(kept < (last - first) / 4);
  return unlike;
}

/// The worth of the best plan: every choice of K rays at every position.
inline double best_of_all(const RayMatrix& matrix, std::uint32_t k) {
  std::vector<std::vector<std::size_t>> subsets;
  for (std::uint32_t mask = 0; mask < (1u << matrix.rays); ++mask) {
    if (static_cast<std::uint32_t>(__builtin_popcount(mask)) != k) continue;
    std::vector<std::size_t>& subset = subsets.emplace_back();
    for (std::uint32_t j = 0; j < matrix.rays; ++j) {
      if ((mask >> j & 1u) != 0) subset.push_back(j);
    }
  }
  std::size_t plans = 1;
  for (std::uint32_t p = 0; p < matrix.positions; ++p) plans *= subsets.size();
  double best = 0;
  for (std::size_t plan = 0; plan < plans; ++plan) {
    std::vector<std::size_t> rows;
    std::size_t rest = plan;
    for (std::uint32_t p = 0; p < matrix.positions; ++p) {
      for (const std::size_t j : subsets[rest % subsets.size()]) rows.push_back(p * matrix.rays + j);
      rest /= subsets.size();
    }
    best = std::max(best, matrix.worth(rows));
  }
  return best;
}

/// The least shares that were found.
struct BoundResult {
  int broken{};
  int bounds{};  ///< that were computed again
  double worst_single{1};
  double worst_joint{1};
  double worst_certificate{1};
};

inline BoundResult check_bounds(std::uint64_t first, std::uint64_t last) {
  BoundResult result;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    const std::uint32_t positions = 1 + static_cast<std::uint32_t>(seed % 2);
    const std::uint32_t columns = positions == 1 ? 5 : 3;
    const SmallSize size{columns, 2, 10, 1 + static_cast<std::uint32_t>(seed / 2 % 3), positions};
    planner::RaySchedulerConfig config = SmallTask::scheduler_config(size, seed);
    config.model.least_visible = 0;
    // Where an earlier stage finds what the exact one does, its plan stays, and its bound is not computed
    // here.
    const bool straight = seed % 4 >= 2;
    config.position_first = !straight;
    config.joint = !straight;
    SmallTask task(size, seed, config);
    const planner::RayScheduler& scheduler = task.finish();
    const RayMatrix matrix = build_ray_matrix(scheduler, task.map.map.view());
    const double best = best_of_all(matrix, size.rays);
    const double own = matrix.worth(chosen_rows(scheduler));
    if (!(best > 1e-9)) continue;
    const planner::RayPlan& plan = scheduler.plan();
    const double k = size.rays;
    const double promised = positions == 1 ? 1 - std::pow(1 - 1 / k, k) : 0.5;
    (positions == 1 ? result.worst_single : result.worst_joint) =
        std::min(positions == 1 ? result.worst_single : result.worst_joint, own / best);
    result.worst_certificate = std::min(result.worst_certificate, plan.certificate);
    // The certificate's bound again, from all rays and in double.
    bool same_bound = true;
    if (plan.stage == planner::RayStage::exact) {
      std::vector<double> left(matrix.entropy.size(), 1.0);
      std::vector<bool> chosen(matrix.size());
      for (const std::size_t row : chosen_rows(scheduler)) {
        matrix.cover(row, left);
        chosen[row] = true;
      }
      double bound = own;
      for (std::uint32_t p = 0; p < positions; ++p) {
        std::vector<double> gains;
        for (std::size_t j = p * matrix.rays; j < (p + 1) * matrix.rays; ++j)
          gains.push_back(chosen[j] ? 0.0 : matrix.gain(j, left));
        std::sort(gains.rbegin(), gains.rend());
        for (std::uint32_t i = 0; i < size.rays; ++i) bound += gains[i];
      }
      same_bound = plan.best_bound == Approx(bound).epsilon(1e-4);
      ++result.bounds;
    }
    const bool good = same_bound && own >= promised * best * (1 - 1e-5) &&
                      plan.best_bound >= best * (1 - 1e-6) && plan.certificate <= own / best * (1 + 1e-5) &&
                      plan.certificate > 0 && plan.worth == Approx(own).epsilon(1e-5);
    result.broken += good ? 0 : 1;
  }
  return result;
}

inline void check_bounds_hold(const BoundResult& result) {
  INFO("worst share of the best plan: one position " << result.worst_single << ", two " << result.worst_joint
                                                     << "; least certificate " << result.worst_certificate);
  CHECK(result.broken == 0);
  CHECK(result.bounds > 100);
  CHECK(result.worst_single < 1);  // or greedy was never put to the test
  CHECK(result.worst_joint < 1);
  CHECK(result.worst_certificate > 0.3);
}

}  // namespace sortie::tests
