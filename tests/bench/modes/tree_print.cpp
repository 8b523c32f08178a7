// SPDX-License-Identifier: BSD-3-Clause
// The grown trees as a table of constants.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {
namespace {

void print_nodes(const GrownTree& tree, std::size_t root) {
  const int base = static_cast<int>(root);
  for (const GrownNode& n : tree)
    std::printf("    {%d, %.3ff, %d, %d, %d, %.3ff, %.3ff, %.3ff},\n", n.feature,
                static_cast<double>(n.bound), n.yes > 0 ? base + n.yes : 0, n.no > 0 ? base + n.no : 0,
                n.idea, n.place_m, std::min(0.5, n.sigma_m), std::min(1.0, n.sigma));
}

void print_table(const char* name, const GrownTree& tree) {
  std::printf("inline constexpr TreeNode %s[] = {\n", name);
  print_nodes(tree, 0);
  std::printf("};\n");
}

}  // namespace

void print_trees(const TrainingSet& set, const std::vector<GrownTree>& pivot, const GrownTree& side,
                 const GrownTree& name) {
  std::size_t nodes = 0;
  for (const GrownTree& tree : pivot) nodes += tree.size();
  std::printf(
      "// SPDX-License-Identifier: BSD-3-Clause\n"
      "// Made by `sortie-bench-modes --train`; not written by hand. %zu, %zu and %zu nodes.\n"
      "#pragma once\n\n#include \"estimators/obstacle_tree.hpp\"\n\nnamespace sortie::estimators {\n\n"
      "/// What kinematics miss on planes, per rad of turn.\n"
      "inline constexpr double kCalmSigma_m = %.3f;\n\n",
      nodes, side.size(), name.size(), std::sqrt(set.calm / set.calm_turn));
  std::printf("inline constexpr TreeNode kPivotTrees[] = {\n");
  nodes = 0;
  for (const GrownTree& tree : pivot) {
    print_nodes(tree, nodes);
    nodes += tree.size();
  }
  std::printf(
      "};\n\n/// Where each tree of the pivot begins.\ninline constexpr std::uint16_t kPivotRoots[] = {");
  nodes = 0;
  for (std::size_t t = 0; t < pivot.size(); ++t) {
    std::printf(t == 0 ? "%zu" : ", %zu", nodes);
    nodes += pivot[t].size();
  }
  std::printf("};\n\n");
  print_table("kSideTree", side);
  std::printf("\n");
  print_table("kNameTree", name);
  std::printf("\n}  // namespace sortie::estimators\n");
}

}  // namespace sortie::bench
