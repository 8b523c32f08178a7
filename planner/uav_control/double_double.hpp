// SPDX-License-Identifier: BSD-3-Clause
// Numbers of twice the precision of a double, for what is computed once at set-up: gains come out the same
// and right to the last bit of a double even where the problem is stiff.
#pragma once

#include <cmath>

namespace sortie::planner {

/// The unevaluated sum of two doubles, |low| <= half an ulp of high: about 31 decimal digits. Sums and
/// products without error (Knuth 1969, Dekker 1971), no fused operations, so every processor has the same
/// bits. Values above 1e290 overflow. 20 to 40 operations each.
struct DoubleDouble {
  double high{};
  double low{};

  constexpr DoubleDouble() = default;
  constexpr DoubleDouble(double value)
      : high(value) {}  // NOLINT(google-explicit-constructor): a number is one
  constexpr DoubleDouble(double h, double l) : high(h), low(l) {}
  explicit constexpr operator double() const { return high + low; }

  /// a + b with |a| >= |b|, without error.
  static constexpr DoubleDouble quick_sum(double a, double b) {
    const double s = a + b;
    return {s, b - (s - a)};
  }
  /// a + b without error.
  static constexpr DoubleDouble exact_sum(double a, double b) {
    const double s = a + b;
    const double t = s - a;
    return {s, (a - (s - t)) + (b - t)};
  }
  /// a * b without error: both are split into halves of 26 bits.
  static constexpr DoubleDouble exact_product(double a, double b) {
    constexpr double kSplit = 134217729.0;  // 2^27 + 1
    const double p = a * b;
    const double ta = kSplit * a;
    const double ah = ta - (ta - a);
    const double al = a - ah;
    const double tb = kSplit * b;
    const double bh = tb - (tb - b);
    const double bl = b - bh;
    return {p, ((ah * bh - p) + ah * bl + al * bh) + al * bl};
  }

  friend constexpr DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble s = exact_sum(a.high, b.high);
    const DoubleDouble t = exact_sum(a.low, b.low);
    const DoubleDouble v = quick_sum(s.high, s.low + t.high);
    return quick_sum(v.high, v.low + t.low);
  }
  friend constexpr DoubleDouble operator-(const DoubleDouble& a) { return {-a.high, -a.low}; }
  friend constexpr DoubleDouble operator-(const DoubleDouble& a, const DoubleDouble& b) { return a + (-b); }
  friend constexpr DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
    const DoubleDouble p = exact_product(a.high, b.high);
    return quick_sum(p.high, p.low + (a.high * b.low + a.low * b.high));
  }
  friend constexpr DoubleDouble operator/(const DoubleDouble& a, const DoubleDouble& b) {
    const double q1 = a.high / b.high;
    const DoubleDouble r = a - DoubleDouble(q1) * b;
    const double q2 = r.high / b.high;
    const DoubleDouble rest = r - DoubleDouble(q2) * b;
    return quick_sum(q1, q2) + DoubleDouble(rest.high / b.high);
  }
};

/// Size as a plain double, for pivots and bounds.
inline double size_of(const DoubleDouble& a) { return std::fabs(a.high); }
inline double size_of(double a) { return std::fabs(a); }

}  // namespace sortie::planner
