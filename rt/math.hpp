// SPDX-License-Identifier: BSD-3-Clause
// Elementary functions with the same bits on every compiler, optimisation level and processor. libm picks its
// code by CPU, so its last bits differ between machines: nothing whose output enters a digest may call it.
//
// Only + - * / sqrt, integer and bit operations are used, in round-to-nearest and with denormals on, compiled
// without contraction to fused multiply-add. Every function is within 1 ulp of the exact value over its whole
// range, takes bounded time, touches constant tables only, and returns one quiet NaN for every NaN.
#pragma once

#include <cstdint>

namespace sortie::rt {

/// Sine and cosine of one angle.
struct SinCos {
  double sin{};
  double cos{};
};

/// Sine of an angle [rad] of any size: the reduction is exact up to the largest double. NaN for an infinity.
double sin(double x);

/// Cosine of an angle [rad] of any size. NaN for an infinity.
double cos(double x);

/// Both at little more than the price of one; the same bits as sin() and cos().
SinCos sincos(double x);

/// Tangent of an angle [rad] of any size. NaN for an infinity. Never infinite: no double is a pole.
double tan(double x);

/// Arc sine [-pi/2, pi/2] of x in [-1, 1]; NaN outside.
double asin(double x);

/// Arc cosine [0, pi] of x in [-1, 1]; NaN outside.
double acos(double x);

/// Arc tangent [-pi/2, pi/2].
double atan(double x);

/// Angle [-pi, pi] of the point (x, y), signs of zeros and infinities as in C's Annex F: -pi of (-1, -0).
double atan2(double y, double x);

/// e^x; infinity above 709.78, gradual underflow to 0 below -708.4.
double exp(double x);

/// Natural logarithm. -infinity for +-0, NaN for negative numbers.
double log(double x);

/// sqrt(x^2 + y^2) without overflow or underflow on the way. An infinity wins over a NaN.
double hypot(double x, double y);

/// Largest whole number that is not above x; x itself for an infinity, a NaN and both zeros. (Some C
/// libraries for small boards have a std::floor that is wrong where doubles are computed in software.)
inline double floor(double x) {
  constexpr double kWhole = 4503599627370496.0;  // 2^52: every double from there on is whole
  if (!(x > -kWhole && x < kWhole)) return x;
  const double cut = static_cast<double>(static_cast<std::int64_t>(x));
  if (cut == x) return x;  // keeps the sign of -0
  return cut > x ? cut - 1.0 : cut;
}

/// True when this thread computes as the digests assume: round to nearest, denormals kept, products rounded
/// before they are added to. Checked at start-up: a library may have told the processor to flush denormals.
bool arithmetic_is_strict();

}  // namespace sortie::rt
