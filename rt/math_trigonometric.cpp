// SPDX-License-Identifier: BSD-3-Clause
// sin, cos, sincos, tan: reduction to [-pi/4, pi/4] in double-double, then minimax polynomials.
#include <cstddef>

#include "rt/math.hpp"
#include "rt/math_detail.hpp"

namespace sortie::rt {
namespace {

using namespace detail;

// An angle less the nearest multiple of pi/2: high + low, and the multiple modulo 4.
struct Reduced {
  double high;
  double low;
  unsigned quadrant;
};

struct Product128 {
  std::uint64_t high;
  std::uint64_t low;
};

Product128 multiply_64(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t a0 = a & 0xffffffffu;
  const std::uint64_t a1 = a >> 32;
  const std::uint64_t b0 = b & 0xffffffffu;
  const std::uint64_t b1 = b >> 32;
  const std::uint64_t low = a0 * b0;
  const std::uint64_t middle = a1 * b0 + (low >> 32);
  const std::uint64_t cross = a0 * b1 + (middle & 0xffffffffu);
  return {a1 * b1 + (middle >> 32) + (cross >> 32), (cross << 32) | (low & 0xffffffffu)};
}

// Payne and Hanek: x = m 2^e times those 192 digits of 2/pi that decide the product modulo 4 and 128 digits
// behind the point. No double comes nearer to a multiple of pi/2 than 2^-62 of it, so at least 66 good digits
// are left. The same work for every argument: 3 products of 64 bits. Needs |x| > pi/4.
Reduced reduce_any(double x) {
  const std::uint64_t bits = bits_of(x);
  const int exponent = static_cast<int>((bits >> 52) & 0x7ff) - 1075;
  const std::uint64_t mantissa = (bits & 0x000fffffffffffffu) | 0x0010000000000000u;
  // Digit number exponent - 1 behind the point is the first that matters; 64 zeros stand in front.
  const unsigned first = static_cast<unsigned>(exponent - 1 + 63);
  const std::uint64_t* const words = kTwoOverPi + first / 64;
  const unsigned shift = first % 64;
  std::uint64_t window[3];
  for (std::size_t i = 0; i < 3; ++i) {
    window[i] = shift == 0 ? words[i] : (words[i] << shift) | (words[i + 1] >> (64 - shift));
  }
  const Product128 low = multiply_64(mantissa, window[2]);
  const Product128 middle = multiply_64(mantissa, window[1]);
  const std::uint64_t word1 = middle.low + low.high;
  const std::uint64_t word0 = mantissa * window[0] + middle.high + (word1 < low.high ? 1u : 0u);

  // Two bits of quadrant, then the fraction; from one half on it is counted down from the next quadrant.
  std::uint64_t high = (word0 << 2) | (word1 >> 62);
  std::uint64_t tail = (word1 << 2) | (low.low >> 62);
  const bool round_up = (high >> 63) != 0;
  unsigned quadrant = static_cast<unsigned>(word0 >> 62) + (round_up ? 1u : 0u);
  if (round_up) {
    high = ~high;
    tail = ~tail;
  }
  int scale = 0;
  if (high == 0) {
    high = tail;
    tail = 0;
    scale = 64;
  }
  const int zeros = std::countl_zero(high);
  if (zeros != 0) {
    high = (high << zeros) | (tail >> (64 - zeros));
    tail <<= zeros;
  }
  scale += zeros;
  const double fraction = static_cast<double>(high >> 11) * power_of_two(-53 - scale);
  const double rest = static_cast<double>(((high & 0x7ff) << 42) | (tail >> 22)) * power_of_two(-106 - scale);
  const HighLow product = two_product(fraction, kPiOver2.high);
  HighLow angle = fast_two_sum(product.high, product.low + (fraction * kPiOver2.low + rest * kPiOver2.high));
  if (round_up != ((bits >> 63) != 0)) angle = {-angle.high, -angle.low};
  if ((bits >> 63) != 0) quadrant = 0u - quadrant;
  return {angle.high, angle.low, quadrant & 3u};
}

// Cody and Waite: pi/2 in three parts, of which the first two have 33 bits, so that their products with the
// multiple are exact. Where the subtraction leaves next to nothing: the long way. Needs |x| finite, > pi/4.
Reduced reduce(double x) {
  constexpr double kTwoOverPiRounded = 0x1.45f306dc9c883p-1;
  constexpr double kPart1 = 0x1.921fb544p+0;
  constexpr double kPart2 = 0x1.0b4611a6p-34;
  constexpr double kPart3 = 0x1.3198a2e037073p-69;
  if (!(std::fabs(x) < 0x1p20)) return reduce_any(x);
  const double shifted = x * kTwoOverPiRounded + kRoundShift;
  const double n = shifted - kRoundShift;
  const HighLow difference = two_sum(x - n * kPart1, -(n * kPart2));
  if (std::fabs(difference.high) < 0x1p-30) return reduce_any(x);
  const HighLow angle = fast_two_sum(difference.high, difference.low - n * kPart3);
  return {angle.high, angle.low, static_cast<unsigned>(bits_of(shifted) & 3u)};
}

// (sin(r) - r) / r^3 as a polynomial in z = r^2, to 2^-58 of sin.
double sin_tail(double z) {
  const double z2 = z * z;
  const double a = -0x1.5555555555549p-3 + z * 0x1.111111110f8a4p-7;
  const double b = -0x1.a01a019c15b3ap-13 + z * 0x1.71de357aac108p-19;
  const double c = -0x1.ae5e68396f31dp-26 + z * 0x1.5d9383b139a5bp-33;
  return a + z2 * (b + z2 * c);
}

// (cos(r) - 1 + r^2/2) / r^4 as a polynomial in z = r^2, to 2^-64 of cos.
double cos_tail(double z) {
  const double z2 = z * z;
  const double a = 0x1.555555555554cp-5 + z * -0x1.6c16c16c1521dp-10;
  const double b = 0x1.a01a019cbf0d1p-16 + z * -0x1.27e4f81264e37p-22;
  const double c = 0x1.1ee9f110372b3p-29 + z * -0x1.8fb109d8e5c7ep-37;
  return a + z2 * (b + z2 * c);
}

double sin_kernel(double r, double low) {
  const double z = r * r;
  return r + (r * (z * sin_tail(z)) + low * (1.0 - 0.5 * z));
}

double cos_kernel(double r, double low) {
  const double z = r * r;
  const double half = 0.5 * z;
  const double main = 1.0 - half;
  return main + (((1.0 - main) - half) + (z * z * cos_tail(z) - r * low));
}

enum class Size { tiny, small, large, not_finite };

// tiny: the first term of the series is the answer; small: no reduction needed.
Size size_of(double x) {
  const std::uint64_t magnitude = bits_of(x) & 0x7fffffffffffffffu;
  if (magnitude <= 0x3fe921fb54442d18u) return magnitude < 0x3e40000000000000u ? Size::tiny : Size::small;
  return magnitude < 0x7ff0000000000000u ? Size::large : Size::not_finite;
}

double sin_of(const Reduced& r) {
  const double value = (r.quadrant & 1u) != 0 ? cos_kernel(r.high, r.low) : sin_kernel(r.high, r.low);
  return (r.quadrant & 2u) != 0 ? -value : value;
}

double cos_of(const Reduced& r) {
  const double value = (r.quadrant & 1u) != 0 ? sin_kernel(r.high, r.low) : cos_kernel(r.high, r.low);
  return ((r.quadrant + 1u) & 2u) != 0 ? -value : value;
}

}  // namespace

double sin(double x) {
  const Size size = size_of(x);
  if (size == Size::small) return sin_kernel(x, 0.0);
  if (size == Size::tiny) return x;
  if (size == Size::not_finite) return quiet_nan();
  return sin_of(reduce(x));
}

double cos(double x) {
  const Size size = size_of(x);
  if (size == Size::small) return cos_kernel(x, 0.0);
  if (size == Size::tiny) return 1.0;
  if (size == Size::not_finite) return quiet_nan();
  return cos_of(reduce(x));
}

SinCos sincos(double x) {
  const Size size = size_of(x);
  if (size == Size::small) return {sin_kernel(x, 0.0), cos_kernel(x, 0.0)};
  if (size == Size::tiny) return {x, 1.0};
  if (size == Size::not_finite) return {quiet_nan(), quiet_nan()};
  const Reduced r = reduce(x);
  return {sin_of(r), cos_of(r)};
}

// sin/cos, each as high + low: the errors of two rounded values and of their quotient add up to over an ulp.
double tan(double x) {
  const Size size = size_of(x);
  if (size == Size::tiny) return x;
  if (size == Size::not_finite) return quiet_nan();
  const Reduced r = size == Size::small ? Reduced{x, 0.0, 0u} : reduce(x);
  const HighLow z = two_square(r.high);
  const double half = 0.5 * z.high;
  const double main = 1.0 - half;
  const HighLow sine = fast_two_sum(r.high, r.high * (z.high * sin_tail(z.high)) + r.low * (1.0 - half));
  const HighLow cosine = fast_two_sum(
      main, ((1.0 - main) - half) + (z.high * z.high * cos_tail(z.high) - (0.5 * z.low + r.high * r.low)));
  const bool inverted = (r.quadrant & 1u) != 0;
  const HighLow above = inverted ? HighLow{-cosine.high, -cosine.low} : sine;
  const HighLow below = inverted ? sine : cosine;
  const double inverse = 1.0 / below.high;
  const double quotient = above.high * inverse;
  const HighLow back = two_product(quotient, below.high);
  const double rest = ((above.high - back.high) - back.low) + (above.low - quotient * below.low);
  return quotient + rest * inverse;
}

}  // namespace sortie::rt
