// SPDX-License-Identifier: BSD-3-Clause
// Mean of paired differences with its 95 % interval.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace sortie::bench {

/// Mean and half the width of the interval in which the true mean lies with 95 %.
struct Interval {
  double mean{};
  double half{};
  double low() const { return mean - half; }
  double high() const { return mean + half; }
};

/// Student's t at 0.975. Beyond the table the first terms of its expansion about the normal one, good to
/// 0.003 from 10 on (Abramowitz and Stegun 26.7.5).
inline double student_975(std::size_t freedom) {
  constexpr double kSmall[] = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262};
  if (freedom < 1) return HUGE_VAL;
  if (freedom <= 9) return kSmall[freedom - 1];
  const double z = 1.959964;
  const auto n = static_cast<double>(freedom);
  const double z3 = z * z * z;
  return z + (z3 + z) / (4 * n) + (5 * z3 * z * z + 16 * z3 + 3 * z) / (96 * n * n);
}

/// Interval of the mean of `differences`, one of each pair: normal up to the mean's own spread.
inline Interval paired_interval(const std::vector<double>& differences) {
  Interval interval;
  const auto n = static_cast<double>(differences.size());
  for (const double d : differences) interval.mean += d / n;
  double squares = 0;
  for (const double d : differences) squares += (d - interval.mean) * (d - interval.mean);
  if (differences.size() < 2) {
    interval.half = HUGE_VAL;
    return interval;
  }
  interval.half = student_975(differences.size() - 1) * std::sqrt(squares / (n - 1) / n);
  return interval;
}

}  // namespace sortie::bench
