// SPDX-License-Identifier: BSD-3-Clause
// From data to pixels: scales and ticks of the axes, linear or logarithmic, the mapping of a plot area, and
// the drawing of one series in it.
#pragma once

#include <string>
#include <vector>

#include "toolchain/report/svg.hpp"

namespace sortie::toolchain {

/// A place on an axis; minor ticks have no label.
struct Tick {
  double value{};
  std::string label;
};

/// Maps data to [0, 1].
struct Scale {
  double low{0.0};
  double high{1.0};
  bool log{false};

  /// Position of `value`; NaN for what a log axis cannot show.
  double position(double value) const;
};

/// A scale over [low, high] with a little room, never empty. With `log` values <= 0 must have been left out.
Scale make_scale(double low, double high, bool log);

/// About `wanted` labelled ticks at 1, 2, 5 x 10^k; on log axes one a decade with minor ticks between, or,
/// where the axis spans less than a decade or so, labels at 1, 2, 5 or as on a linear axis: never fewer than
/// two labels.
std::vector<Tick> make_ticks(const Scale& scale, int wanted);

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
