// SPDX-License-Identifier: BSD-3-Clause
// Receiver operating characteristics as a benchmark reports them: areas with their range, and lines.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/bench/recognition/roc_curve.hpp"
#include "tests/bench/report/picture.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::bench {

inline double thousandths(double value) { return std::round(1000 * value) / 1000; }
inline double percent(double share) { return std::round(1000 * share) / 10; }

/// {value, low, high}: of all halls; between which nine of ten drawn sets of halls lie.
inline Json drawn_range(double value, const std::vector<double>& of_draws) {
  Rounds rounds;
  for (const double v : of_draws) rounds.add(v);
  return {{"value", thousandths(value)},
          {"low", thousandths(rounds.quantile(0.05))},
          {"high", thousandths(rounds.quantile(0.95))}};
}

/// Sets of as many halls, drawn with repeats from those that there are.
class DrawnHalls {
 public:
  static constexpr int kDraws = 200;

  DrawnHalls(std::size_t halls, std::uint64_t seed) {
    testing::Draws random(seed);
    const double n = static_cast<double>(halls);
    for (int i = 0; i < kDraws; ++i) {
      std::vector<double>& times = times_.emplace_back(halls, 0.0);
      for (std::size_t h = 0; h < halls; ++h) times[static_cast<std::size_t>(random.uniform(0, n))] += 1.0;
    }
  }
  /// One a draw.
  std::vector<double> areas(const RocCurve& roc) const {
    std::vector<double> areas;
    for (const std::vector<double>& times : times_) areas.push_back(roc.area(times));
    return areas;
  }

 private:
  std::vector<std::vector<double>> times_;  ///< how often each hall counts
};

/// At most about 200 corners of a curve.
inline Curve roc_line(const RocCurve& roc, const std::string& name, const std::string& style) {
  Curve curve{name, {}, {}, {}, style, -1};
  double next = 0.0;
  for (std::size_t i = 0; i < roc.false_share().size(); ++i) {
    const double way = roc.false_share()[i] + roc.true_share()[i];  // rises with every corner
    if (way < next && i + 1 < roc.false_share().size()) continue;
    next = way + 0.01;
    curve.x.push_back(thousandths(roc.false_share()[i]));
    curve.y.push_back(thousandths(roc.true_share()[i]));
  }
  return curve;
}

}  // namespace sortie::bench
