// SPDX-License-Identifier: BSD-3-Clause
// From data to pixels: the mapping of a plot area and the drawing of one series in it.
#pragma once

#include <string>

#include "toolchain/report/axis.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// A plot area in px, y down.
struct Frame {
  double left{};
  double top{};
  double width{};
  double height{};
};

/// Data to px.
struct Mapping {
  Scale x;
  Scale y;
  Frame frame;

  double px(double value) const { return frame.left + x.position(value) * frame.width; }
  double py(double value) const { return frame.top + (1.0 - y.position(value)) * frame.height; }
};

/// SVG elements of one series. Lines with ascending x keep first, lowest, highest and last of each pixel
/// column; other lines skip points closer than a third of a pixel.
std::string draw_series(const Series& series, const Mapping& map);

}  // namespace sortie::toolchain
