// SPDX-License-Identifier: BSD-3-Clause
// exp, log, hypot, and the check of the arithmetic they stand on.
#include "rt/math.hpp"
#include "rt/math_detail.hpp"

namespace sortie::rt {
namespace {

using namespace detail;

// (main + small) 2^k below the normal range, rounded once: 2^(-1022 - k) puts the last place where it is due.
double exp_subnormal(double main, double small, int k) {
  const double anchor = power_of_two(-1022 - k);
  const HighLow value = fast_two_sum(main, small);
  const HighLow shifted = fast_two_sum(anchor, value.high);
  const double rounded = (shifted.high + (shifted.low + value.low)) - anchor;
  return rounded * 0x1p-600 * power_of_two(k + 600);
}

}  // namespace

// x = (64 k + i) ln2/64 + r: e^x = 2^k 2^(i/64) e^r.
double exp(double x) {
  constexpr double kPerLn2 = 0x1.71547652b82fep+6;  // 64/ln2
  constexpr double kStepHigh = 0x1.62e42fecp-7;     // ln2/64, 31 bits
  constexpr double kStepLow = 0x1.d1cf79abc9e3bp-38;
  if (!(x <= 0x1.62e42fefa39efp+9)) return x != x ? quiet_nan() : kInfinity;
  if (x < -745.2) return 0.0;
  const double shifted = x * kPerLn2 + kRoundShift;
  const double n = shifted - kRoundShift;
  const int whole = static_cast<int>(n);
  const int k = whole >> 6;
  const double r = (x - n * kStepHigh) - n * kStepLow;
  const double r2 = r * r;
  const double tail =
      r + r2 * ((0.5 + r * 0x1.55555555548ecp-3) +
                r2 * (0x1.55555555545dbp-5 + r * 0x1.111123b47144cp-7 + r2 * 0x1.6c16db4187f79p-10));
  const HighLow step = kExp2Table[whole & 63];
  const double small = step.low + step.high * tail;
  if (k < -1022) return exp_subnormal(step.high, small, k);
  // k is 1024 where x rounds up to the power above; in two steps the scale then still is a double.
  const double value = step.high + small;
  return k < 1023 ? value * power_of_two(k) : value * power_of_two(k - 1) * 2.0;
}

// x = 2^k m with m in [0.703, 1.406): log x = k ln2 - log(c) + log(1 + r), 1 + r = m c, with c of 9 bits so
// that r is exact in two parts.
double log(double x) {
  constexpr double kLn2High = 0x1.62e42fefa38p-1;  // 42 bits: k ln2 + log(c) is exact
  constexpr double kLn2Low = 0x1.ef35793c7673p-45;
  std::uint64_t bits = bits_of(x);
  int k = 0;
  if (bits - 0x0010000000000000u >= 0x7fe0000000000000u) {  // zero, subnormal, negative, infinite or NaN
    if (x == 0.0) return -kInfinity;
    if (x == kInfinity) return x;
    if (!(x > 0.0)) return quiet_nan();
    bits = bits_of(x * 0x1p54);
    k = -54;
  }
  const unsigned cell = static_cast<unsigned>(bits >> 46) & 63u;
  const bool halved = cell >= 26;
  k += static_cast<int>(bits >> 52) - 1023 + (halved ? 1 : 0);
  const double m =
      from_bits((bits & 0x000fffffffffffffu) | (halved ? 0x3fe0000000000000u : 0x3ff0000000000000u));
  const LogEntry entry = kLogTable[cell];
  const double m_high = upper_half(m);
  const HighLow r = two_sum(m_high * entry.inverse - 1.0, (m - m_high) * entry.inverse);
  const double base = static_cast<double>(k) * kLn2High + entry.high;
  const HighLow sum = fast_two_sum(base, r.high);
  const double r2 = r.high * r.high;
  const double tail = (0x1.5555555555285p-2 + r.high * -0x1.ffffffffb0472p-3) +
                      r2 * ((0x1.999999d442573p-3 + r.high * -0x1.55558218d2970p-3) +
                            r2 * (0x1.248dd70951803p-3 + r.high * -0x1.f3749c091c567p-4));
  const double low = static_cast<double>(k) * kLn2Low + entry.low + r.low;
  return sum.high + (sum.low + (low + r2 * (r.high * tail - 0.5)));
}

double hypot(double x, double y) {
  const double ax = std::fabs(x);
  const double ay = std::fabs(y);
  double a = ax > ay ? ax : ay;
  double b = ax > ay ? ay : ax;
  if (!(ax < kInfinity && ay < kInfinity)) {
    return ax == kInfinity || ay == kInfinity ? kInfinity : quiet_nan();
  }
  if (b <= a * 0x1p-54) return a + b;
  double back = 1.0;
  if (a > 0x1p500) {
    a *= 0x1p-600;
    b *= 0x1p-600;
    back = 0x1p600;
  } else if (b < 0x1p-400) {
    a *= 0x1p600;
    b *= 0x1p600;
    back = 0x1p-600;
  }
  // The root's square less a^2 + b^2, by way of the root's distance to a or b, which is exact (C. Borges, "An
  // improved algorithm for hypot(a,b)", 2019), takes the rounding errors of the sum back out.
  const double root = std::sqrt(a * a + b * b);
  double excess = 0.0;
  if (root <= 2.0 * b) {
    const double over = root - b;
    excess = a * (2.0 * over - a) + (over - 2.0 * (a - b)) * over;
  } else {
    const double over = root - a;
    excess = 2.0 * over * (a - 2.0 * b) + ((4.0 * over - b) * b + over * over);
  }
  return (root - excess / (2.0 * root)) * back;
}

bool arithmetic_is_strict() {
  // Volatile, so that the running processor answers and not the compiler.
  const volatile double smallest_normal = 0x1p-1022;
  const volatile double one = 1.0;
  const volatile double half_ulp = 0x1p-53;
  const volatile double denormal = smallest_normal * 0.5;
  const bool keeps_denormals = denormal != 0.0 && denormal * 2.0 == smallest_normal;
  const bool rounds_to_nearest =
      one + half_ulp == 1.0 && one + 0x1.8p-53 == 1.0 + 0x1p-52 && -one - half_ulp == -1.0;
  // The product rounds to 1; a fused multiply-add (no -ffp-contract=off) would keep the -2^-60.
  const volatile double above = 1.0 + 0x1p-30;
  const volatile double below = 1.0 - 0x1p-30;
  const bool rounds_products = above * below - one == 0.0;
  return keeps_denormals && rounds_to_nearest && rounds_products;
}

}  // namespace sortie::rt
