// SPDX-License-Identifier: BSD-3-Clause
// Grows a decision tree whose leaves choose the idea that misses least (CART, Breiman et al. 1984, with the
// squared miss of the best idea as impurity).
#pragma once

#include <vector>

#include "estimators/obstacle_modes.hpp"

namespace sortie::bench {

/// One step of a drive.
struct TrainingStep {
  float features[estimators::kModeFeatures];
  float normals[estimators::kPivotIdeas];  ///< what each idea says of the motion along the normal
  float sides[3];
  float nose_up, roll, moved, weight, way, direction;
  float of_pivot, of_side;  ///< what the trees so far make of it
  bool settled;
};

/// All of them.
struct TrainingSet {
  std::vector<TrainingStep> steps;
  double calm{}, calm_turn{};  ///< squared misses on planes, and turns there

  /// A step over `way_m` that moved `moved_m` along the normal, and stands for `share` of them.
  void add(const estimators::ObstacleModes& modes, const estimators::ObstacleStep& step, double way_m,
           double moved_m, double share);
};

/// A node while it grows; yes = 0: a leaf.
struct GrownNode {
  int feature{};
  float bound{};
  int yes{}, no{}, idea{};
  double place_m{}, sigma_m{}, sigma{};
};

/// Learns the idea of the pivot (or of the side) from what the other tree leaves over, and notes its answers.
std::vector<GrownNode> grow_pivot_tree(TrainingSet& set, int depth);
std::vector<GrownNode> grow_side_tree(TrainingSet& set, int depth);

/// The table as C++.
void print_trees(const TrainingSet& set, const std::vector<GrownNode>& pivot,
                 const std::vector<GrownNode>& side);

}  // namespace sortie::bench
