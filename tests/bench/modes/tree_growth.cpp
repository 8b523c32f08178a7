// SPDX-License-Identifier: BSD-3-Clause
// What a miss is for each tree: the squared error of the best idea, or steps of another mode.
#include "tests/bench/modes/tree_growth.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/bench/modes/tree_grower.hpp"

namespace sortie::bench {
namespace {

using estimators::kModeFeatures;
using estimators::PivotIdea;

constexpr double kFixedBetter = 0.97;  // a place of no other meaning must be so much better than an idea
constexpr double kFarthest_m = 0.3;
constexpr double kRolling = 2e-4;       // rad per metre below which a settled robot does not roll
constexpr double kDrivesSeen = 0.7;     // share of the drives that one of many trees sees
constexpr double kFeaturesAsked = 0.6;  // and of the features that it asks at a node
constexpr int kFixed = static_cast<int>(PivotIdea::fixed);
constexpr std::size_t kModes = 4;
constexpr double kPivotWorth = 1.6;  // an edge pivot is short and lies between two others

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

/// Chooses an idea of the pivot or of the side.
struct IdeaTask {
  using Sums = Misses;
  bool side{};

  void count(const TrainingStep& s, Misses& sum) const {
    const double w = static_cast<double>(s.weight);
    const double left = static_cast<double>(s.moved - (side ? s.of_pivot : s.of_side));
    const double turn = static_cast<double>(side ? s.roll : s.nose_up);
    for (int k = 0; k < (side ? 3 : kFixed); ++k) {
      const double says = static_cast<double>(side ? -s.roll * s.sides[k] : s.normals[k]);
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

  double best(const Misses& m, GrownNode& node) const {
    node.idea = 0;
    node.place_m = 0.0;
    for (int k = 1; k < (side ? 3 : kFixed); ++k)
      if (m.idea[static_cast<std::size_t>(k)] < m.idea[static_cast<std::size_t>(node.idea)]) node.idea = k;
    double least = m.idea[static_cast<std::size_t>(node.idea)];
    if (!side && m.arm > 0.0) {
      const double place = std::clamp(-m.both / m.arm, -kFarthest_m, kFarthest_m);
      const double misses = m.squared + 2.0 * place * m.both + place * place * m.arm;
      if (misses < kFixedBetter * least) {
        least = misses;
        node.idea = kFixed;
        node.place_m = place;
      }
    }
    node.sigma_m = std::sqrt(std::max(0.0, least) / std::max(1e-12, m.turned));
    node.sigma = std::sqrt(std::max(0.0, least) / std::max(1e-12, m.way));
    return least;
  }
};

/// Travel in each true mode.
struct Travels {
  std::array<double, kModes> mode{};
  std::size_t steps{};
  void add(const Travels& o, double sign) {
    for (std::size_t k = 0; k < kModes; ++k) mode[k] += sign * o.mode[k];
    steps = sign > 0 ? steps + o.steps : steps - o.steps;
  }
};

/// Chooses a name; Gini's impurity.
struct NameTask {
  using Sums = Travels;
  std::array<double, kModes> worth{};  ///< of a metre in each mode

  void count(const TrainingStep& s, Travels& sum) const {
    const auto k = static_cast<std::size_t>(s.mode);
    sum.mode[k] += worth[k] * static_cast<double>(s.weight * s.way * s.way);
    ++sum.steps;
  }

  double best(const Travels& t, GrownNode& node) const {
    double all = 0.0, squares = 0.0;
    node.idea = 0;
    for (std::size_t k = 0; k < kModes; ++k) {
      const double way = std::max(0.0, t.mode[k]);
      all += way;
      squares += way * way;
      if (way > t.mode[static_cast<std::size_t>(node.idea)]) node.idea = static_cast<int>(k);
    }
    if (all <= 0.0) return 0.0;
    node.sigma = t.mode[static_cast<std::size_t>(node.idea)] / all;  // how sure
    return all - squares / all;
  }
};

const GrownNode& leaf_of(const GrownTree& tree, const TrainingStep& s) {
  std::size_t k = 0;
  while (tree[k].yes != 0)
    k = static_cast<std::size_t>(s.features[tree[k].feature] < tree[k].bound ? tree[k].yes : tree[k].no);
  return tree[k];
}

}  // namespace

void TrainingSet::add(const estimators::ObstacleModes& modes, const estimators::ObstacleStep& step,
                      double way_m, double moved_m, int mode, double share) {
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
  s.mode = static_cast<std::int8_t>(mode);
  s.drive = drive;
  s.settled = modes.settled();
  steps.push_back(s);
}

std::vector<GrownTree> grow_pivot_trees(TrainingSet& set, int trees, int depth) {
  std::vector<GrownTree> grown;
  for (int t = 0; t < trees; ++t) {
    hil::Random random(static_cast<std::uint64_t>(t) + 1, 0x62616767);
    std::vector<bool> seen(set.drive + 1);
    for (std::size_t d = 0; d < seen.size(); ++d) seen[d] = random.chance(kDrivesSeen);
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < set.steps.size(); ++i)
      if (!set.steps[i].settled && seen[set.steps[i].drive]) all.push_back(i);
    GrowthLimits limits;
    limits.depth = depth;
    limits.features_asked = kFeaturesAsked;
    limits.seed = static_cast<std::uint64_t>(t) + 1;
    grown.push_back(TreeGrower<IdeaTask>(set.steps, {false}, limits).grow(std::move(all)));
  }
  for (TrainingStep& s : set.steps) {
    s.of_pivot = 0.0f;
    for (const GrownTree& tree : grown) {
      const GrownNode& leaf = leaf_of(tree, s);
      const float says = s.settled             ? 0.0f
                         : leaf.idea == kFixed ? -s.nose_up * s.direction * static_cast<float>(leaf.place_m)
                                               : s.normals[leaf.idea];
      s.of_pivot += says / static_cast<float>(trees);
    }
  }
  return grown;
}

GrownTree grow_side_tree(TrainingSet& set, int depth) {
  std::vector<std::size_t> all(set.steps.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
  GrowthLimits limits;
  limits.depth = depth;
  GrownTree tree = TreeGrower<IdeaTask>(set.steps, {true}, limits).grow(std::move(all));
  for (TrainingStep& s : set.steps) s.of_side = -s.roll * s.sides[leaf_of(tree, s).idea];
  return tree;
}

GrownTree grow_name_tree(const TrainingSet& set, int depth) {
  std::vector<std::size_t> all;
  Travels total;
  NameTask task;
  task.worth.fill(1.0);
  for (std::size_t i = 0; i < set.steps.size(); ++i) {
    if (set.steps[i].settled || set.steps[i].mode < 0) continue;
    all.push_back(i);
    task.count(set.steps[i], total);
  }
  for (std::size_t k = 0; k < kModes; ++k) task.worth[k] = 1.0 / std::max(1e-9, total.mode[k]);
  task.worth[2] *= kPivotWorth;
  GrowthLimits limits;
  limits.depth = depth;
  return TreeGrower<NameTask>(set.steps, task, limits).grow(std::move(all));
}

}  // namespace sortie::bench
