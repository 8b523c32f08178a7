// SPDX-License-Identifier: BSD-3-Clause
// What tables of looks say: rounded means and medians.
#pragma once

#include <cmath>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// Root mean square to three places; 0 of nothing.
inline double rms(const Rounds& rounds) {
  double sum = 0.0;
  for (const double v : rounds.values()) sum += v * v;
  return rounds.empty() ? 0.0
                        : std::round(1000.0 * std::sqrt(sum / static_cast<double>(rounds.size()))) / 1000.0;
}

/// Median to one place, or a dash.
inline Json median(const Rounds& rounds) {
  return rounds.empty() ? Json("-") : Json(std::round(10 * rounds.median()) / 10);
}

}  // namespace sortie::bench
