// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/modes/tree_growth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace sortie::bench {
namespace {

using estimators::kModeFeatures;
using estimators::PivotIdea;

constexpr std::size_t kFewest = 400;   // steps of a leaf
constexpr std::size_t kBounds = 32;    // that are tried for a feature, quantiles
constexpr double kWorthIt = 0.995;     // a question must lower the misses to this share
constexpr double kFixedBetter = 0.97;  // and a place of no other meaning must be so much better
constexpr double kFarthest_m = 0.3;
constexpr double kRolling = 2e-4;  // rad per metre below which a settled robot does not roll
constexpr int kFixed = static_cast<int>(PivotIdea::fixed);

/// Sums of squared misses, from which the best idea follows.
struct Misses {
  std::array<double, estimators::kPivotIdeas> idea{};
  double squared{}, arm{}, both{};  ///< for the best fixed place
  double turned{}, way{};
  std::size_t steps{};

  void add(const Misses& o, double sign) {
    for (std::size_t k = 0; k < idea.size(); ++k) idea[k] += sign * o.idea[k];
    squared += sign * o.squared;
    arm += sign * o.arm;
    both += sign * o.both;
    turned += sign * o.turned;
    way += sign * o.way;
    steps = sign > 0 ? steps + o.steps : steps - o.steps;
  }
};

/// One tree: which part of a step it explains.
class Growth {
 public:
  Growth(const std::vector<TrainingStep>& steps, bool side, int depth)
      : steps_(steps), side_(side), depth_(depth) {}

  std::vector<GrownNode> grow() {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < steps_.size(); ++i)
      if (side_ || !steps_[i].settled) all.push_back(i);
    grow_at(all, 0);
    return std::move(nodes_);
  }

 private:
  void count(const TrainingStep& s, Misses& sum) const {
    const double w = static_cast<double>(s.weight);
    const double left = static_cast<double>(s.moved - (side_ ? s.of_pivot : s.of_side));
    const double turn = static_cast<double>(side_ ? s.roll : s.nose_up);
    for (int k = 0; k < (side_ ? 3 : kFixed); ++k) {
      const double says = static_cast<double>(side_ ? -s.roll * s.sides[k] : s.normals[k]);
      sum.idea[static_cast<std::size_t>(k)] += w * (left - says) * (left - says);
    }
    const double arm = turn * static_cast<double>(s.direction);
    sum.squared += w * left * left;
    sum.arm += w * arm * arm;
    sum.both += w * left * arm;
    sum.turned += w * turn * turn;
    sum.way += w * static_cast<double>(s.way) * static_cast<double>(s.way);
    ++sum.steps;
  }

  double best(const Misses& m, int& idea, double& place_m) const {
    idea = 0;
    place_m = 0.0;
    for (int k = 1; k < (side_ ? 3 : kFixed); ++k)
      if (m.idea[static_cast<std::size_t>(k)] < m.idea[static_cast<std::size_t>(idea)]) idea = k;
    double least = m.idea[static_cast<std::size_t>(idea)];
    if (side_ || m.arm <= 0.0) return least;
    const double place = std::clamp(-m.both / m.arm, -kFarthest_m, kFarthest_m);
    const double misses = m.squared + 2.0 * place * m.both + place * place * m.arm;
    if (misses < kFixedBetter * least) {
      least = misses;
      idea = kFixed;
      place_m = place;
    }
    return least;
  }

  double split(const std::vector<std::size_t>& at, std::size_t feature, const Misses& total, double goal,
               float& bound) const {
    std::vector<float> sorted;
    for (const std::size_t i : at) sorted.push_back(steps_[i].features[feature]);
    std::sort(sorted.begin(), sorted.end());
    std::vector<float> bounds;
    for (std::size_t q = 1; q < kBounds; ++q) {
      const float b = std::round(sorted[sorted.size() * q / kBounds] * 1000.0f) / 1000.0f;
      if (bounds.empty() || b > bounds.back()) bounds.push_back(b);
    }
    std::vector<Misses> bins(bounds.size() + 1);
    for (const std::size_t i : at) {
      const auto bin =
          std::upper_bound(bounds.begin(), bounds.end(), steps_[i].features[feature]) - bounds.begin();
      count(steps_[i], bins[static_cast<std::size_t>(bin)]);
    }
    Misses below;
    for (std::size_t k = 0; k < bounds.size(); ++k) {
      below.add(bins[k], 1.0);
      Misses above = total;
      above.add(below, -1.0);
      if (below.steps < kFewest || above.steps < kFewest) continue;
      int idea;
      double place;
      const double misses = best(below, idea, place) + best(above, idea, place);
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
    Misses total;
    for (const std::size_t i : at) count(steps_[i], total);
    GrownNode node;
    const double misses = best(total, node.idea, node.place_m);
    node.sigma_m = std::sqrt(misses / std::max(1e-12, total.turned));
    node.sigma = std::sqrt(misses / std::max(1e-12, total.way));
    int chosen = -1;
    double goal = kWorthIt * misses - 1e-9;
    if (depth < depth_ && at.size() >= 2 * kFewest) {
      for (std::size_t f = 0; f < kModeFeatures; ++f) {
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
  bool side_;
  int depth_;
  std::vector<GrownNode> nodes_;
};

const GrownNode& leaf_of(const std::vector<GrownNode>& tree, const TrainingStep& s) {
  std::size_t k = 0;
  while (tree[k].yes != 0)
    k = static_cast<std::size_t>(s.features[tree[k].feature] < tree[k].bound ? tree[k].yes : tree[k].no);
  return tree[k];
}

void print_tree(const char* name, const std::vector<GrownNode>& tree) {
  std::printf("inline constexpr TreeNode %s[] = {\n", name);
  for (const GrownNode& n : tree)
    std::printf("    {%d, %.3ff, %d, %d, %d, %.3ff, %.3ff, %.3ff},\n", n.feature,
                static_cast<double>(n.bound), n.yes, n.no, n.idea, n.place_m, std::min(0.5, n.sigma_m),
                std::min(1.0, n.sigma));
  std::printf("};\n");
}

}  // namespace

void TrainingSet::add(const estimators::ObstacleModes& modes, const estimators::ObstacleStep& step,
                      double way_m, double moved_m, double share) {
  if (modes.settled() && std::fabs(step.turn_rad.x) < kRolling * way_m) {
    calm += moved_m * moved_m / way_m;
    calm_turn += step.turn_rad.y * step.turn_rad.y / way_m;
    return;
  }
  TrainingStep s{};
  for (std::size_t k = 0; k < kModeFeatures; ++k) s.features[k] = static_cast<float>(modes.features()[k]);
  for (std::uint8_t k = 0; k < estimators::kPivotIdeas; ++k)
    s.normals[k] = static_cast<float>(modes.normal_of(static_cast<PivotIdea>(k)));
  for (std::uint8_t k = 0; k < 3; ++k)
    s.sides[k] = static_cast<float>(modes.side_of(static_cast<estimators::SideIdea>(k)));
  s.nose_up = static_cast<float>(-step.turn_rad.y);
  s.roll = static_cast<float>(step.turn_rad.x);
  s.moved = static_cast<float>(moved_m);
  s.weight = static_cast<float>(share / way_m);  // the sum over a way does not depend on speed
  s.way = static_cast<float>(way_m);
  s.direction = step.travel_m < 0.0 ? -1.0f : 1.0f;
  s.settled = modes.settled();
  steps.push_back(s);
}

std::vector<GrownNode> grow_pivot_tree(TrainingSet& set, int depth) {
  std::vector<GrownNode> tree = Growth(set.steps, false, depth).grow();
  for (TrainingStep& s : set.steps) {
    const GrownNode& leaf = leaf_of(tree, s);
    s.of_pivot = s.settled             ? 0.0f
                 : leaf.idea == kFixed ? -s.nose_up * s.direction * static_cast<float>(leaf.place_m)
                                       : s.normals[leaf.idea];
  }
  return tree;
}

std::vector<GrownNode> grow_side_tree(TrainingSet& set, int depth) {
  std::vector<GrownNode> tree = Growth(set.steps, true, depth).grow();
  for (TrainingStep& s : set.steps) s.of_side = -s.roll * s.sides[leaf_of(tree, s).idea];
  return tree;
}

void print_trees(const TrainingSet& set, const std::vector<GrownNode>& pivot,
                 const std::vector<GrownNode>& side) {
  std::printf(
      "// SPDX-License-Identifier: BSD-3-Clause\n"
      "// Made by `sortie-bench-modes --train`; not written by hand. %zu and %zu nodes.\n"
      "#pragma once\n\n#include \"estimators/obstacle_tree.hpp\"\n\nnamespace sortie::estimators {\n\n"
      "/// What kinematics miss on planes, per rad of turn.\n"
      "inline constexpr double kCalmSigma_m = %.3f;\n\n",
      pivot.size(), side.size(), std::sqrt(set.calm / set.calm_turn));
  print_tree("kPivotTree", pivot);
  std::printf("\n");
  print_tree("kSideTree", side);
  std::printf("\n}  // namespace sortie::estimators\n");
}

}  // namespace sortie::bench
