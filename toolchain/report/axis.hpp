// SPDX-License-Identifier: BSD-3-Clause
// Scales and ticks of a plot axis, linear or logarithmic.
#pragma once

#include <string>
#include <vector>

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

}  // namespace sortie::toolchain
