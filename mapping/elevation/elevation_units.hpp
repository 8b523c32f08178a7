// SPDX-License-Identifier: BSD-3-Clause
// The whole numbers of the elevation map: lengths along the ground, heights, weights.
#pragma once

#include <cmath>
#include <cstdint>

namespace sortie::mapping {

/// Units of a metre along the ground: sixteenths of a millimetre, so that cells of whole millimetres and
/// whole metres of offset are whole numbers.
inline constexpr double kGroundUnits = 16000.0;
/// Units of a metre of height, above the map's own level: 1 um, so that the least gain of a filter still
/// moves it.
inline constexpr double kHeightUnits = 1048576.0;
/// Heights of a map reach this far above and below its level.
inline constexpr double kHeightRange_m = 1000.0;
/// A weight of 1 is a standard deviation of 0.64 m; weights are inverse variances, 65535 is 2.5 mm.
inline constexpr double kUnitWeightVariance_m2 = 0.4096;
/// Variance that motion adds is counted in these parts of the unit weight's: 2.4e-8 m^2.
inline constexpr double kVarianceParts = 16777216.0;

/// Nearest whole number, halves away from zero: of -x it is the negative. |x| below 2^62.
inline std::int64_t nearest_unit(double x) { return static_cast<std::int64_t>(x < 0.0 ? x - 0.5 : x + 0.5); }

/// Largest whole number that is not above x. |x| below 2^62.
inline std::int64_t unit_below(double x) {
  const auto cut = static_cast<std::int64_t>(x);
  return cut - (static_cast<double>(cut) > x ? 1 : 0);
}

/// Quotient rounded to the nearest whole number, halves away from zero. b > 0.
template <class T>
constexpr T divide_nearest(T a, T b) {
  return (a < 0 ? a - b / 2 : a + b / 2) / b;
}

}  // namespace sortie::mapping
