// SPDX-License-Identifier: BSD-3-Clause
// The grown trees as tables of constants, a few trees of the pivot in each file.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "tests/bench/modes/tree_growth.hpp"

namespace sortie::bench {
namespace {

constexpr std::size_t kColumns = 150;
constexpr std::size_t kTreesAFile = 3;

std::string begin_of(const std::string& about) {
  return "// SPDX-License-Identifier: BSD-3-Clause\n// Made by `sortie-bench-modes --train`; not written by "
         "hand. " +
         about + "\n#pragma once\n\n";
}

// Nodes follow each other as TreeGrower makes them: the one that `yes` leads to comes next.
void put(std::ofstream& out, const std::string& name, const GrownTree& tree) {
  out << "// clang-format off\ninline constexpr TreeNode " << name << "[] = {";
  std::size_t column = kColumns;
  for (const GrownNode& n : tree) {
    char node[120];
    if (n.yes != 0) {
      std::snprintf(node, sizeof node, "{%d, %d, %.3ff},", n.feature, n.no, static_cast<double>(n.bound));
    } else {
      std::snprintf(node, sizeof node, "{%d, 0, %.3ff, %.3ff, %.3ff},", n.idea, n.place_m,
                    std::min(0.5, n.sigma_m), std::min(1.0, n.sigma));
    }
    const std::size_t size = std::string(node).size();
    const bool fits = column + 1 + size <= kColumns;
    out << (fits ? ' ' : '\n') << node;
    column = fits ? column + 1 + size : size;
  }
  out << "\n};\n// clang-format on\n";
}

}  // namespace

void print_trees(const TrainingSet& set, const std::vector<GrownTree>& pivot, const GrownTree& side,
                 const GrownTree& name) {
  const std::string space = "namespace sortie::estimators {\n\n";
  const std::string end = "\n}  // namespace sortie::estimators\n";
  std::string includes, all;
  for (std::size_t first = 0; first < pivot.size(); first += kTreesAFile) {
    const std::string file = "obstacle_pivot_trees_" + std::to_string(first / kTreesAFile + 1) + ".hpp";
    const std::size_t last = std::min(first + kTreesAFile, pivot.size());
    std::string sizes;
    for (std::size_t t = first; t < last; ++t)
      sizes += (t == first ? "" : ", ") + std::to_string(pivot[t].size());
    std::ofstream out(file);
    out << begin_of(sizes + " nodes.") << "#include \"estimators/obstacle_tree.hpp\"\n\n" << space;
    for (std::size_t t = first; t < last; ++t) {
      const std::string tree = "kPivotTree" + std::to_string(t + 1);
      out << (t == first ? "" : "\n");
      put(out, tree, pivot[t]);
      all += (t == 0 ? "" : ", ") + tree;
    }
    out << end;
    includes += "#include \"estimators/" + file + "\"\n";
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
