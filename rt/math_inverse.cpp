// SPDX-License-Identifier: BSD-3-Clause
// asin, acos, atan, atan2.
#include "rt/math.hpp"
#include "rt/math_detail.hpp"

namespace sortie::rt {
namespace {

using namespace detail;

// (asin(s) - s) / s^3 as a polynomial in z = s^2 <= 1/4, to 2^-55 of asin.
double asin_tail(double z) {
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double a = (0x1.5555555555384p-3 + z * 0x1.333333336fe22p-4) +
                   z2 * (0x1.6db6db4198b23p-5 + z * 0x1.f1c72c80d29bdp-6);
  const double b = (0x1.6e89ed9b43be7p-6 + z * 0x1.1c6c4489ad42fp-6) +
                   z2 * (0x1.c6f6397e687dcp-7 + z * 0x1.8ef3d135d6d71p-7);
  const double c = (0x1.aa2e0e3621a24p-8 + z * 0x1.410ef3628434fp-6) +
                   z2 * (-0x1.0b897a57b6ea7p-6 + z * 0x1.0602307aedc78p-5);
  return a + z4 * (b + z4 * c);
}

// asin(sqrt((1 - a)/2)) for a in [1/2, 1) as high + low: the complement's half angle.
HighLow half_complement(double a) {
  const double z = 0.5 * (1.0 - a);
  const double root = std::sqrt(z);
  const double high = upper_half(root);
  const double rest = (z - high * high) / (root + high);  // root = high + rest to 2^-74
  return {high, rest + root * (z * asin_tail(z))};
}

// atan(a/b) for 0 < a <= b as high + low; a/b >= 2^-61 and neither near overflow or underflow.
HighLow atan_ratio(double a, double b) {
  const double inverse = 1.0 / b;
  const double ratio = a * inverse;
  if (ratio < 0.234375) {
    // The series, with what the quotient lost given back.
    const HighLow back = two_product(ratio, b);
    const double rest = ((a - back.high) - back.low) * inverse;
    const double z = ratio * ratio;
    const double z2 = z * z;
    const double first = (-0x1.555555555551fp-2 + z * 0x1.9999999989f0dp-3) +
                         z2 * (-0x1.2492491838e82p-3 + z * 0x1.c71c6858ae593p-4);
    const double second = (-0x1.745b180da9173p-4 + z * 0x1.3ad459d311a65p-4) +
                          z2 * (-0x1.0c798d9bf9c90p-4 + z * 0x1.843f669e9c10fp-5);
    const double tail = first + z2 * z2 * second;
    return {ratio, rest + ratio * (z * tail)};
  }
  // With c = i/32 next to a/b: atan(a/b) = atan(c) + atan((a - c b)/(b + c a)), 1/15 of it at most.
  const int cell =
      static_cast<int>(ratio * 32.0 + 0.5);  // NOLINT(bugprone-incorrect-roundings): any near cell will do
  const double c = static_cast<double>(cell) * 0x1p-5;
  const double b_high = upper_half(b);
  const double t = ((a - c * b_high) - c * (b - b_high)) / (b + c * a);
  const double z = t * t;
  const double tail = (-0x1.5555555555555p-2 + z * 0x1.99999999922cep-3) +
                      z * z * (-0x1.249247ac56eb8p-3 + z * 0x1.c6e3a73bc003dp-4);
  const HighLow base = kAtanTable[cell - kAtanFirstCell];
  const HighLow sum = fast_two_sum(base.high, t);
  return {sum.high, sum.low + (base.low + t * (z * tail))};
}

double with_sign(double magnitude, double sign) {
  return from_bits((bits_of(magnitude) & 0x7fffffffffffffffu) | (bits_of(sign) & 0x8000000000000000u));
}

// Directions along an axis or to infinity, where only signs count. `x_weight` and `y_weight` are 0 or 1.
double axis_angle(bool x_weight, bool y_weight, double x, double y) {
  const bool behind = (bits_of(x) >> 63) != 0;
  double angle = behind ? kPi.high : 0.0;
  if (y_weight) angle = kPiOver2.high;
  if (x_weight && y_weight) angle = behind ? 0x1.2d97c7f3321d2p+1 : 0.5 * kPiOver2.high;  // 3 pi/4 or pi/4
  return with_sign(angle, y);
}

}  // namespace

double asin(double x) {
  const double a = std::fabs(x);
  if (a < 0.5) {
    const double z = x * x;
    return a < 0x1p-27 ? x : x + x * (z * asin_tail(z));
  }
  if (!(a < 1.0)) return a == 1.0 ? with_sign(kPiOver2.high, x) : quiet_nan();
  const HighLow half = half_complement(a);
  const HighLow main = fast_two_sum(kPiOver2.high, -2.0 * half.high);
  return with_sign(main.high + (main.low + (kPiOver2.low - 2.0 * half.low)), x);
}

double acos(double x) {
  const double a = std::fabs(x);
  if (a < 0.5) {
    const double z = x * x;
    const HighLow main = fast_two_sum(kPiOver2.high, -x);
    return main.high + (main.low + (kPiOver2.low - x * (z * asin_tail(z))));
  }
  if (!(a < 1.0)) return x == 1.0 ? 0.0 : (x == -1.0 ? kPi.high : quiet_nan());
  const HighLow half = half_complement(a);
  if (x > 0.0) return 2.0 * (half.high + half.low);
  const HighLow main = fast_two_sum(kPi.high, -2.0 * half.high);
  return main.high + (main.low + (kPi.low - 2.0 * half.low));
}

double atan(double x) { return atan2(x, 1.0); }

double atan2(double y, double x) {
  double ax = std::fabs(x);
  double ay = std::fabs(y);
  if (!(ax < kInfinity && ay < kInfinity)) {
    if (!(ax == ax && ay == ay)) return quiet_nan();
    return axis_angle(ax == kInfinity, ay == kInfinity, x, y);
  }
  if (ay == 0.0 || ax == 0.0) return axis_angle(false, ay != 0.0, x, y);

  const bool behind = x < 0.0;
  const bool steep = ay > ax;
  double a = steep ? ax : ay;
  double b = steep ? ay : ax;
  HighLow angle{0.0, 0.0};
  if (b > 0x1p500) {
    a *= 0x1p-600;
    b *= 0x1p-600;
  } else if (b < 0x1p-400) {
    a *= 0x1p600;
    b *= 0x1p600;
  }
  if (a < b * 0x1p-60) {
    if (!steep && !behind) return y / x;  // correctly rounded, also where it underflows
  } else {
    angle = atan_ratio(a, b);
  }
  // The octant's own angle is counted up or down from an axis.
  static constexpr HighLow kAxis[4] = {{0.0, 0.0}, kPi, kPiOver2, kPiOver2};
  static constexpr double kDirection[4] = {1.0, -1.0, -1.0, 1.0};
  const unsigned octant = (steep ? 2u : 0u) + (behind ? 1u : 0u);
  const double direction = kDirection[octant];
  const HighLow main = fast_two_sum(kAxis[octant].high, direction * angle.high);
  return with_sign(main.high + (main.low + (kAxis[octant].low + direction * angle.low)), y);
}

}  // namespace sortie::rt
