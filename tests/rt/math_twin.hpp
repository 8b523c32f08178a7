// SPDX-License-Identifier: BSD-3-Clause
// A wider twin for every function of rt/math, and the distance to it in units of the last place.
#pragma once

#include <cfloat>
#include <cmath>
#include <cstdint>
#include <limits>

#if defined(SORTIE_QUADMATH)
#include <quadmath.h>
#endif

#include "rt/math.hpp"

namespace sortie::rt::test {

#if defined(SORTIE_QUADMATH)
using Wide = __float128;
#define SORTIE_WIDE(name) name##q
#else
using Wide = long double;
#define SORTIE_WIDE(name) name##l
#endif

/// False where long double is no wider than double: there is no twin then.
inline constexpr bool kWideIsWider =
#if defined(SORTIE_QUADMATH)
    true;
#else
    LDBL_MANT_DIG >= 64;
#endif

inline Wide wide_sin(Wide x) { return SORTIE_WIDE(sin)(x); }
inline Wide wide_cos(Wide x) { return SORTIE_WIDE(cos)(x); }
inline Wide wide_tan(Wide x) { return SORTIE_WIDE(tan)(x); }
inline Wide wide_asin(Wide x) { return SORTIE_WIDE(asin)(x); }
inline Wide wide_acos(Wide x) { return SORTIE_WIDE(acos)(x); }
inline Wide wide_atan(Wide x) { return SORTIE_WIDE(atan)(x); }
inline Wide wide_exp(Wide x) { return SORTIE_WIDE(exp)(x); }
inline Wide wide_log(Wide x) { return SORTIE_WIDE(log)(x); }
inline Wide wide_atan2(Wide y, Wide x) { return SORTIE_WIDE(atan2)(y, x); }
inline Wide wide_hypot(Wide x, Wide y) { return SORTIE_WIDE(hypot)(x, y); }

/// |got - exact| in units of the last place that a double of exact's size has (2^-1074 below the normal
/// range).
inline double ulps(double got, Wide exact) {
  const double rounded = static_cast<double>(exact);
  if (std::isinf(rounded) || std::isnan(rounded)) {
    const bool same = std::isnan(rounded) ? std::isnan(got) : got == rounded;
    return same ? 0.0 : std::numeric_limits<double>::infinity();
  }
  int exponent = 0;
  static_cast<void>(SORTIE_WIDE(frexp)(exact, &exponent));
  const int last = exponent - 53 < -1074 ? -1074 : exponent - 53;
  const double distance =
      static_cast<double>(SORTIE_WIDE(ldexp)(SORTIE_WIDE(fabs)(static_cast<Wide>(got) - exact), -last));
  return std::isnan(distance) ? std::numeric_limits<double>::infinity() : distance;
}

/// xorshift64*: the same numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return state_ * 0x2545f4914f6cdd1du;
  }
  /// [0, 1)
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// (-size, size)
  double within(double size) { return (2.0 * unit() - 1.0) * size; }
  /// Any finite double, every exponent as likely.
  double any() {
    for (;;) {
      const double x = from_bits(bits());
      if (std::isfinite(x)) return x;
    }
  }
  /// A double within `steps` representable numbers of x.
  double beside(double x, unsigned steps) {
    const std::uint64_t base = std::bit_cast<std::uint64_t>(x);
    return from_bits(base + bits() % (2u * steps + 1u) - steps);
  }
  static double from_bits(std::uint64_t bits) { return std::bit_cast<double>(bits); }

 private:
  std::uint64_t state_;
};

/// Worst distance of one function over `count` arguments, and where.
struct Worst {
  double ulps{-1.0};
  double x{};
  double y{};
};

template <class F, class G, class Make>
Worst worst_of_one(F function, G twin, Make make, int count) {
  Worst worst;
  for (int i = 0; i < count; ++i) {
    const double x = make();
    const double distance = ulps(function(x), twin(static_cast<Wide>(x)));
    if (distance > worst.ulps) worst = {distance, x, 0.0};
  }
  return worst;
}

template <class F, class G, class MakeX, class MakeY>
Worst worst_of_two(F function, G twin, MakeX make_x, MakeY make_y, int count) {
  Worst worst;
  for (int i = 0; i < count; ++i) {
    const double x = make_x();
    const double y = make_y();
    const double distance = ulps(function(x, y), twin(static_cast<Wide>(x), static_cast<Wide>(y)));
    if (distance > worst.ulps) worst = {distance, x, y};
  }
  return worst;
}

/// Calls report(name, worst) for every function over every class of arguments: `count` of each class.
template <class Report>
void measure_all(int count, std::uint64_t seed, Report report) {
  Random random(seed);
  const auto any = [&random] { return random.any(); };
  const auto positive = [&random] { return std::fabs(random.any()); };
  const auto subnormal = [&random] { return Random::from_bits(random.bits() >> 12); };
  const auto within = [&random](double size) { return [&random, size] { return random.within(size); }; };
  const auto near_pole = [&random] {  // next to multiples of pi/2, where almost everything cancels
    const double multiple = static_cast<double>(random.bits() % 2000000u) * 1.5707963267948966;
    return random.beside(multiple + 1.5707963267948966, 4);
  };
  const auto beside_pole = [&random] {  // where the short reduction's last part decides
    const double multiple = static_cast<double>(random.bits() % 660000u + 1u) * 1.5707963267948966;
    return multiple + random.within(1.0) * Random::from_bits((1023u - random.bits() % 32u) << 52);
  };
  const auto nearest_pole = [&random] {  // below 2^20, where the short reduction would lose most
    constexpr double kNearest[] = {0x1.6c6cbc45dc8dep+5, 0x1.93c05c9ed3cbcp+18, 0x1.bf9b3c6059d24p+17,
                                   -0x1.39c6fd67805a7p+18};
    const double nearest = kNearest[random.bits() % 4u];
    return random.bits() % 2u == 0 ? nearest : 2.0 * nearest;
  };
  const auto near_one = [&random] {
    const double gap = random.unit() * Random::from_bits((1023u - random.bits() % 54u) << 52);
    return random.bits() % 2 == 0 ? 1.0 - gap : gap - 1.0;
  };
  const auto around_one = [&random] {
    return 1.0 + random.within(0.3) * Random::from_bits((1023u - random.bits() % 50u) << 52);
  };

  for (const double size : {0.8, 7.0, 1e3, 1e6, 2e6, 1e10, 1e22}) {
    report("sin", worst_of_one(sin, wide_sin, within(size), count));
    report("cos", worst_of_one(cos, wide_cos, within(size), count));
    report("tan", worst_of_one(tan, wide_tan, within(size), count));
  }
  report("sin of any double", worst_of_one(sin, wide_sin, any, count));
  report("cos of any double", worst_of_one(cos, wide_cos, any, count));
  report("tan of any double", worst_of_one(tan, wide_tan, any, count));
  report("sin near pi/2 k", worst_of_one(sin, wide_sin, near_pole, count));
  report("cos near pi/2 k", worst_of_one(cos, wide_cos, near_pole, count));
  report("tan near pi/2 k", worst_of_one(tan, wide_tan, near_pole, count));
  report("sin beside pi/2 k", worst_of_one(sin, wide_sin, beside_pole, count));
  report("cos beside pi/2 k", worst_of_one(cos, wide_cos, beside_pole, count));
  report("tan beside pi/2 k", worst_of_one(tan, wide_tan, beside_pole, count));
  report("sin nearest pi/2 k", worst_of_one(sin, wide_sin, nearest_pole, 100));
  report("cos nearest pi/2 k", worst_of_one(cos, wide_cos, nearest_pole, 100));
  report("tan nearest pi/2 k", worst_of_one(tan, wide_tan, nearest_pole, 100));
  report("asin", worst_of_one(asin, wide_asin, within(1.0), count));
  report("acos", worst_of_one(acos, wide_acos, within(1.0), count));
  report("asin near 1", worst_of_one(asin, wide_asin, near_one, count));
  report("acos near 1", worst_of_one(acos, wide_acos, near_one, count));
  report("asin of tiny", worst_of_one(asin, wide_asin, within(1e-6), count));
  report("atan", worst_of_one(atan, wide_atan, within(3.0), count));
  report("atan of any double", worst_of_one(atan, wide_atan, any, count));
  report("atan2", worst_of_two(atan2, wide_atan2, within(3.0), within(3.0), count));
  report("atan2, flat", worst_of_two(atan2, wide_atan2, within(1e-3), within(1.0), count));
  report("atan2, steep", worst_of_two(atan2, wide_atan2, within(1.0), within(1e-9), count));
  report("atan2 of any doubles", worst_of_two(atan2, wide_atan2, any, any, count));
  report("atan2 of subnormals", worst_of_two(atan2, wide_atan2, subnormal, subnormal, count));
  report("exp", worst_of_one(exp, wide_exp, within(745.0), count));
  report("exp of small", worst_of_one(exp, wide_exp, within(1.0), count));
  report("exp of tiny", worst_of_one(exp, wide_exp, within(1e-9), count));
  const auto underflowing = [&random] { return -708.3 - 37.0 * random.unit(); };
  const auto overflowing = [&random] { return 709.7 + 0.1 * random.unit(); };
  report("exp below the normal range", worst_of_one(exp, wide_exp, underflowing, count));
  report("exp at overflow", worst_of_one(exp, wide_exp, overflowing, count));
  report("log of any double", worst_of_one(log, wide_log, positive, count));
  report("log of subnormals", worst_of_one(log, wide_log, subnormal, count));
  report("log near 1", worst_of_one(log, wide_log, around_one, count));
  report("hypot", worst_of_two(hypot, wide_hypot, within(3.0), within(3.0), count));
  report("hypot, uneven", worst_of_two(hypot, wide_hypot, within(1e-5), within(1.0), count));
  report("hypot of any doubles", worst_of_two(hypot, wide_hypot, any, any, count));
  report("hypot of subnormals", worst_of_two(hypot, wide_hypot, subnormal, subnormal, count));
}

}  // namespace sortie::rt::test
