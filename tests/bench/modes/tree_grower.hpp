// SPDX-License-Identifier: BSD-3-Clause
// Grows a decision tree (CART, Breiman et al. 1984) for a task that says what a miss is.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "hil/random.hpp"
#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {

/// How a tree grows.
struct GrowthLimits {
  int depth{8};
  std::size_t fewest{300};     ///< steps of a leaf
  double worth_it{0.995};      ///< a question must lower the misses to this share
  double features_asked{1.0};  ///< share of the features that a node looks at
  std::uint64_t seed{1};       ///< of which ones
};

/// One tree. A Task has Sums with add(other, sign) and steps, count(step, sums) and best(sums, node), which
/// chooses the node's answer and returns what it misses.
template <class Task>
class TreeGrower {
 public:
  TreeGrower(const std::vector<TrainingStep>& steps, const Task& task, const GrowthLimits& limits)
      : steps_(steps), task_(task), limits_(limits), random_(limits.seed, 0x74726565) {}

  std::vector<GrownNode> grow(std::vector<std::size_t> all) {
    grow_at(all, 0);
    return std::move(nodes_);
  }

 private:
  using Sums = typename Task::Sums;
  static constexpr std::size_t kBounds = 32;      // that are tried for a feature, quantiles
  static constexpr std::size_t kLookedAt = 4000;  // steps for the quantiles

  double split(const std::vector<std::size_t>& at, std::size_t feature, const Sums& total, double goal,
               float& bound) const {
    std::vector<float> sorted;
    const std::size_t stride = 1 + at.size() / kLookedAt;
    for (std::size_t i = 0; i < at.size(); i += stride) sorted.push_back(steps_[at[i]].features[feature]);
    std::sort(sorted.begin(), sorted.end());
    std::vector<float> bounds;
    for (std::size_t q = 1; q < kBounds; ++q) {
      const float b = std::round(sorted[sorted.size() * q / kBounds] * 1000.0f) / 1000.0f;
      if (bounds.empty() || b > bounds.back()) bounds.push_back(b);
    }
    std::vector<Sums> bins(bounds.size() + 1);
    for (const std::size_t i : at) {
      const auto bin =
          std::upper_bound(bounds.begin(), bounds.end(), steps_[i].features[feature]) - bounds.begin();
      task_.count(steps_[i], bins[static_cast<std::size_t>(bin)]);
    }
    Sums below;
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      below.add(bins[k], 1.0);
      Sums above = total;
      above.add(below, -1.0);
      if (below.steps < limits_.fewest || above.steps < limits_.fewest) continue;
      GrownNode answer;
      const double left = task_.best(below, answer);
      const double misses = left + task_.best(above, answer);
      if (misses < goal) {
        goal = misses;
        bound = bounds[k];
      }
    }
    return goal;
  }

  int grow_at(std::vector<std::size_t>& at, int depth) {
    const std::size_t me = nodes_.size();
    nodes_.emplace_back();
    Sums total;
    for (const std::size_t i : at) task_.count(steps_[i], total);
    GrownNode node;
    const double misses = task_.best(total, node);
    int chosen = -1;
    double goal = limits_.worth_it * misses - 1e-9;
    if (depth < limits_.depth && at.size() >= 2 * limits_.fewest) {
      for (std::size_t f = 0; f < estimators::kModeFeatures; ++f) {
        if (!random_.chance(limits_.features_asked)) continue;
        const double reached = split(at, f, total, goal, node.bound);
        if (reached < goal) {
          goal = reached;
          chosen = static_cast<int>(f);
        }
      }
    }
    if (chosen >= 0) {
      node.feature = chosen;
      std::vector<std::size_t> yes, no;
      for (const std::size_t i : at)
        (steps_[i].features[static_cast<std::size_t>(chosen)] < node.bound ? yes : no).push_back(i);
      std::vector<std::size_t>().swap(at);
      node.yes = grow_at(yes, depth + 1);
      node.no = grow_at(no, depth + 1);
    }
    nodes_[me] = node;
    return static_cast<int>(me);
  }

  const std::vector<TrainingStep>& steps_;
  Task task_;
  GrowthLimits limits_;
  hil::Random random_;
  std::vector<GrownNode> nodes_;
};

}  // namespace sortie::bench
