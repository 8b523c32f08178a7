// SPDX-License-Identifier: BSD-3-Clause
// Where the texts beside points go, so that none covers another.
#pragma once

#include <string_view>
#include <vector>

#include "toolchain/report/svg_path.hpp"

namespace sortie::toolchain {

/// A rectangle of a picture, px, y down.
struct LabelBox {
  double left{};
  double top{};
  double right{};
  double bottom{};
};

/// A text beside the point (x, y).
struct PlacedLabel {
  double x{};         ///< of the text's anchor
  double y{};         ///< of its base line
  bool ends_there{};  ///< the text ends at x; otherwise it begins there
  bool is_far{};      ///< so far from its point that a line should lead to it
};

/// Width that a text of the labels' size is taken to have, px: the average of a sans-serif face, and some.
double label_width(std::string_view text);

/// The place for each of `texts` beside its point, in their order: the nearest that keeps within the frame
/// and off the texts placed before, off `taken`, and where it can off the points. One that finds no such
/// place goes where it covers least. Time: texts times what there is to keep off.
std::vector<PlacedLabel> lay_labels(const std::vector<std::string_view>& texts, const std::vector<double>& x,
                                    const std::vector<double>& y, const Frame& frame,
                                    std::vector<LabelBox> taken);

}  // namespace sortie::toolchain
