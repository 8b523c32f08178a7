// SPDX-License-Identifier: BSD-3-Clause
// The grown trees as tables of constants, one file a tree of the pivot.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {
namespace {

constexpr std::size_t kNodesALine = 3;

std::string begin_of(const std::string& about) {
  return "// SPDX-License-Identifier: BSD-3-Clause\n// Made by `sortie-bench-modes --train`; not written by "
         "hand. " +
         about + "\n#pragma once\n\n";
}

void put(std::ofstream& out, const std::string& name, const GrownTree& tree) {
  out << "// clang-format off\ninline constexpr TreeNode " << name << "[] = {\n";
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const GrownNode& n = tree[i];
    char node[120];
    std::snprintf(node, sizeof node, "{%d, %.3ff, %d, %d, %d, %.3ff, %.3ff, %.3ff},", n.feature,
                  static_cast<double>(n.bound), n.yes, n.no, n.idea, n.place_m, std::min(0.5, n.sigma_m),
                  std::min(1.0, n.sigma));
    out << node << ((i + 1) % kNodesALine == 0 || i + 1 == tree.size() ? '\n' : ' ');
  }
  out << "};\n// clang-format on\n";
}

}  // namespace

void print_trees(const TrainingSet& set, const std::vector<GrownTree>& pivot, const GrownTree& side,
                 const GrownTree& name) {
  const std::string space = "namespace sortie::estimators {\n\n";
  const std::string end = "\n}  // namespace sortie::estimators\n";
  std::string includes, all;
  for (std::size_t t = 0; t < pivot.size(); ++t) {
    const std::string number = std::to_string(t + 1);
    const std::string file = "obstacle_pivot_tree_" + number + ".hpp";
    std::ofstream out(file);
    out << begin_of(std::to_string(pivot[t].size()) + " nodes.")
        << "#include \"estimators/obstacle_tree.hpp\"\n\n"
        << space;
    put(out, "kPivotTree" + number, pivot[t]);
    out << end;
    includes += "#include \"estimators/" + file + "\"\n";
    all += (t == 0 ? "kPivotTree" : ", kPivotTree") + number;
  }
  std::ofstream out("obstacle_tree_table.hpp");
  out << begin_of(std::to_string(side.size()) + " and " + std::to_string(name.size()) + " nodes here.")
      << includes << '\n'
      << space
      << "/// What kinematics miss on planes, per rad of turn.\ninline constexpr double kCalmSigma_m = ";
  char sigma[32];
  std::snprintf(sigma, sizeof sigma, "%.3f", std::sqrt(set.calm / set.calm_turn));
  out << sigma << ";\n\n/// The trees of the pivot; the motion is their mean.\n"
      << "inline constexpr const TreeNode* kPivotTrees[] = {" << all << "};\n\n";
  put(out, "kSideTree", side);
  out << '\n';
  put(out, "kNameTree", name);
  out << end;
}

}  // namespace sortie::bench
