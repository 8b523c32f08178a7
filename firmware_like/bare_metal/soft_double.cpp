// SPDX-License-Identifier: BSD-3-Clause
// Sums of doubles, and conversions to double, for processors that have no instructions for them (Cortex-M4F).
// libgcc has its own, which rounds 1 - x to the wrong side for one x in four between 2^-34 and 2^-33: one
// digit of the last place, and every digest after it. These names take their place; products, quotients,
// roots and comparisons stay libgcc's.
//
// Round to nearest, ties to even, denormals kept (IEEE 754-2019, 5.4.1). Doubles come and go in integer
// registers, as the "Run-time ABI for the Arm architecture" (IHI 0043) asks: their types here are integers.
#include <bit>
#include <cstdint>
#include <utility>

namespace {

using Bits = std::uint64_t;

constexpr Bits kSign = Bits{1} << 63;
constexpr Bits kHidden = Bits{1} << 52;
constexpr Bits kFraction = kHidden - 1;
constexpr Bits kInfinity = Bits{0x7ff} << 52;
constexpr Bits kQuiet = kInfinity | kHidden >> 1;
constexpr int kGuard = 10;  // bits behind the last place; the lowest stands for all that was shifted out

// `digits` has its highest set bit at or below 62, at 62 unless the exponent is 1 (a denormal).
Bits rounded(Bits sign, int exponent, Bits digits) {
  const Bits rest = digits & ((Bits{1} << kGuard) - 1);
  const Bits half = Bits{1} << (kGuard - 1);
  digits >>= kGuard;
  if (rest > half || (rest == half && (digits & 1) != 0)) ++digits;
  // A carry out of the fraction goes on into the exponent, where the hidden digit counts as one, too.
  const Bits all = (static_cast<Bits>(exponent - 1) << 52) + digits;
  return sign | (all < kInfinity ? all : kInfinity);
}

Bits normalised(Bits sign, int exponent, Bits digits) {
  int shift = std::countl_zero(digits) - 1;
  if (shift >= exponent) shift = exponent - 1;
  return rounded(sign, exponent - shift, digits << shift);
}

Bits sum(Bits a, Bits b) {
  if ((a & ~kSign) < (b & ~kSign)) std::swap(a, b);
  if ((a & ~kSign) > kInfinity) return a | kQuiet;
  if ((a & ~kSign) == kInfinity) return a == (b ^ kSign) ? kQuiet : a;
  const auto digits_of = [](Bits value) {
    return ((value & kInfinity) == 0 ? value & kFraction : (value & kFraction) | kHidden) << kGuard;
  };
  const auto exponent_of = [](Bits value) {
    const int exponent = static_cast<int>(value >> 52 & 0x7ff);
    return exponent == 0 ? 1 : exponent;
  };
  int exponent = exponent_of(a);
  const int apart = exponent - exponent_of(b);
  const Bits larger = digits_of(a);
  Bits smaller = digits_of(b);
  if (apart > 63) {
    smaller = smaller == 0 ? 0 : 1;
  } else {
    const Bits lost = smaller & ((Bits{1} << apart) - 1);
    smaller = smaller >> apart | (lost == 0 ? 0 : 1);
  }
  const Bits sign = a & kSign;
  if (((a ^ b) & kSign) == 0) {
    Bits digits = larger + smaller;
    if (digits >> 63 != 0) {
      digits = digits >> 1 | (digits & 1);
      ++exponent;
    }
    return rounded(sign, exponent, digits);
  }
  const Bits digits = larger - smaller;
  return digits == 0 ? 0 : normalised(sign, exponent, digits);
}

// The value of `whole`, at most 2^64 - 1, is digits * 2^(exponent - 1023 - 62).
Bits converted(Bits sign, std::uint64_t whole) {
  if (whole == 0) return 0;
  const bool wide = whole >> 63 != 0;
  if (wide) whole = whole >> 1 | (whole & 1);
  return normalised(sign, 1023 + 62 + (wide ? 1 : 0), whole);
}

}  // namespace

extern "C" {

Bits __aeabi_dadd(Bits a, Bits b) { return sum(a, b); }
Bits __aeabi_dsub(Bits a, Bits b) { return sum(a, b ^ kSign); }
Bits __aeabi_drsub(Bits a, Bits b) { return sum(b, a ^ kSign); }
Bits __aeabi_ul2d(std::uint64_t value) { return converted(0, value); }
Bits __aeabi_ui2d(std::uint32_t value) { return converted(0, value); }
Bits __aeabi_l2d(std::int64_t value) {
  return value < 0 ? converted(kSign, -static_cast<std::uint64_t>(value))
                   : converted(0, static_cast<std::uint64_t>(value));
}
Bits __aeabi_i2d(std::int32_t value) { return __aeabi_l2d(value); }

Bits __aeabi_f2d(std::uint32_t value) {
  const Bits sign = Bits{value & 0x80000000u} << 32;
  const std::uint32_t exponent = value >> 23 & 0xffu;
  const Bits fraction = value & 0x7fffffu;
  if (exponent == 0xff) return sign | (fraction == 0 ? kInfinity : kQuiet | fraction << 29);
  if (exponent != 0) return sign | Bits{exponent + 1023 - 127} << 52 | fraction << 29;
  // A denormal is fraction * 2^-149.
  return fraction == 0 ? sign : normalised(sign, 1023 + 62 - 149, fraction);
}

// The names that GCC has for them.
Bits __adddf3(Bits, Bits) __attribute__((alias("__aeabi_dadd")));
Bits __subdf3(Bits, Bits) __attribute__((alias("__aeabi_dsub")));
Bits __floatundidf(std::uint64_t) __attribute__((alias("__aeabi_ul2d")));
Bits __floatunsidf(std::uint32_t) __attribute__((alias("__aeabi_ui2d")));
Bits __floatdidf(std::int64_t) __attribute__((alias("__aeabi_l2d")));
Bits __floatsidf(std::int32_t) __attribute__((alias("__aeabi_i2d")));
Bits __extendsfdf2(std::uint32_t) __attribute__((alias("__aeabi_f2d")));
}
