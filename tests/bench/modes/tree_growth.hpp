// SPDX-License-Identifier: BSD-3-Clause
// The trees that training grows: ideas of the pivot (a handful, averaged), of the side, and names of modes.
#pragma once

#include <cstdint>
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
  std::uint32_t drive;      ///< which one it belongs to
  std::int8_t mode;         ///< true one as seen along the way, -1: none that has a name
  bool settled;
};

/// All of them.
struct TrainingSet {
  std::vector<TrainingStep> steps;
  double calm{}, calm_turn{};  ///< squared misses on planes, and turns there
  std::uint32_t drive{};       ///< the one that is being added

  /// A step over `way_m` that moved `moved_m` along the normal in this true mode, and stands for `share` of
  /// them.
  void add(const estimators::ObstacleModes& modes, const estimators::ObstacleStep& step, double way_m,
           double moved_m, int mode, double share);
};

/// A node while it grows; yes = 0: a leaf.
struct GrownNode {
  int feature{};
  float bound{};
  int yes{}, no{}, idea{};
  double place_m{}, sigma_m{}, sigma{};
};
using GrownTree = std::vector<GrownNode>;

/// Learns ideas of the pivot (or of the side) from what the others leave over, and notes the answers. Each
/// tree of the pivot sees other drives and asks other features; their mean errs less than each.
std::vector<GrownTree> grow_pivot_trees(TrainingSet& set, int trees, int depth);
GrownTree grow_side_tree(TrainingSet& set, int depth);

/// Learns the names; all modes count alike, however rare.
GrownTree grow_name_tree(const TrainingSet& set, int depth);

/// The tables as C++, into files of the current folder: obstacle_pivot_trees_N.hpp, obstacle_tree_table.hpp.
void print_trees(const TrainingSet& set, const std::vector<GrownTree>& pivot, const GrownTree& side,
                 const GrownTree& name);

}  // namespace sortie::bench
