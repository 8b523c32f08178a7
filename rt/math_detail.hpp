// SPDX-License-Identifier: BSD-3-Clause
// Building blocks of the elementary functions: bit access, sums and products with their rounding error.
#pragma once

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>

#include "rt/math_tables.hpp"

#ifdef __FAST_MATH__
#error "rt/math needs IEEE arithmetic: build without -ffast-math"
#endif
static_assert(FLT_EVAL_METHOD == 0, "rt/math needs doubles that are computed as doubles");

namespace sortie::rt::detail {

inline constexpr HighLow kPiOver2{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
inline constexpr HighLow kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
inline constexpr double kInfinity = __builtin_huge_val();
// Added to a double below 2^51 and taken off, rounds it to an integer, which also stands in the low bits.
inline constexpr double kRoundShift = 0x1.8p52;

inline std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x); }
inline double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }

// Which NaN an operation makes differs between processors; here there is only this one.
inline double quiet_nan() { return from_bits(0x7ff8000000000000u); }

// 2^k for a normal result, -1022 <= k <= 1023.
inline double power_of_two(int k) { return from_bits(static_cast<std::uint64_t>(k + 1023) << 52); }

// The upper 26 bits of x: products of two such are exact.
inline double upper_half(double x) { return from_bits(bits_of(x) & 0xfffffffff8000000u); }

// a + b = high + low exactly, for |a| >= |b| or a = 0.
inline HighLow fast_two_sum(double a, double b) {
  const double sum = a + b;
  return {sum, (a - sum) + b};
}

// a + b = high + low exactly.
inline HighLow two_sum(double a, double b) {
  const double sum = a + b;
  const double part = sum - a;
  return {sum, (a - (sum - part)) + (b - part)};
}

// a * b = high + low, to 2^-106.
inline HighLow two_product(double a, double b) {
  const double product = a * b;
  const double a_high = upper_half(a);
  const double b_high = upper_half(b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

// a * a = high + low, to 2^-106.
inline HighLow two_square(double a) {
  const double square = a * a;
  const double a_high = upper_half(a);
  const double a_low = a - a_high;
  return {square, ((a_high * a_high - square) + 2.0 * a_high * a_low) + a_low * a_low};
}

}  // namespace sortie::rt::detail
