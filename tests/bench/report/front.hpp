// SPDX-License-Identifier: BSD-3-Clause
// Cells of a sweep as a table and a picture: error over cost, what no other beats, and the defaults.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/report/picture.hpp"

namespace sortie::bench {

/// One choice of knobs.
struct FrontCell {  // NOLINT(bugprone-exception-escape): JSON's own move
  std::string curve;
  std::string label;
  Json row;  ///< as the table's columns, without the last one
  double cost{};
  double error{};
  bool by_itself{};  ///< what it does when nobody says anything
};

/// Which cells a table shows.
enum class FrontRows { all, front };

/// The table gets a last column with "front", "defaults" or both; the picture a curve of dots for each
/// `curve`, with labels on the front alone.
void add_front(Report& report, Picture picture, std::vector<std::string> columns,
               const std::vector<FrontCell>& cells, FrontRows rows);

/// A number with so many decimals, for a table.
std::string decimals(double value, int count);

}  // namespace sortie::bench
