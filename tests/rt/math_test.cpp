// SPDX-License-Identifier: BSD-3-Clause
// rt/math against a wide twin, at the edges of its range, and against the bits that every build must give.
#include "rt/math.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cfenv>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "tests/rt/math_twin.hpp"

namespace sortie::rt::test {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRoundedPi = 0x1.921fb54442d18p+1;
constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
constexpr double kLargest = std::numeric_limits<double>::max();

std::uint64_t bits(double x) { return std::bit_cast<std::uint64_t>(x); }

bool is_the_nan(double x) { return bits(x) == 0x7ff8000000000000u; }

bool same(double a, double b) { return bits(a) == bits(b); }

// FNV-1a over the 8 bytes of each double: independent of the library's own digest.
class Fnv {
 public:
  void add(double x) {
    for (int shift = 0; shift < 64; shift += 8) {
      state_ = (state_ ^ ((bits(x) >> shift) & 0xffu)) * 0x100000001b3u;
    }
  }
  std::uint64_t value() const { return state_; }

 private:
  std::uint64_t state_{0xcbf29ce484222325u};
};

template <class F>
std::uint64_t fingerprint(F function) {
  Random random(0x600d5eed);
  Fnv fnv;
  for (int i = 0; i < 4000; ++i) {
    const double any_x = random.any();  // one draw an expression: the order of arguments is the compiler's
    const double any_y = random.any();
    fnv.add(function(any_x, any_y));
    const double small_x = random.within(1.0);
    const double small_y = random.within(1.0);
    fnv.add(function(small_x, small_y));
    const double middle_x = random.within(100.0);
    const double middle_y = random.within(0.01);
    fnv.add(function(middle_x, middle_y));
    const double large_x = random.within(1e7);
    const double large_y = random.within(1e3);
    fnv.add(function(large_x, large_y));
    const double near_one_x = 1.0 + random.within(0.05);
    const double near_one_y = 1.0 - 0.05 * random.unit();
    fnv.add(function(near_one_x, near_one_y));
    const double deep_x = -727.0 + random.within(20.0);  // where exp underflows gradually
    fnv.add(function(deep_x, near_one_x));
  }
  for (const double x :
       {0.0, -0.0, 1.0, -1.0, kInf, -kInf, kNan, kSmallest, -kSmallest, kLargest, 1e22, -745.0}) {
    for (const double y : {0.0, -0.0, 1.0, -1.0, kInf, -kInf, kNan, kSmallest, kLargest})
      fnv.add(function(x, y));
  }
  return fnv.value();
}

}  // namespace

TEST_CASE("every function is within one ulp of a wider twin", "[math]") {
  if constexpr (!kWideIsWider) {
    WARN("skipped: long double is no wider than double here; the fingerprint test stands in");
    return;
  }
  measure_all(30000, 0x5eed5eed5eed5eedu, [](const char* name, const Worst& worst) {
    INFO(name << ": " << worst.ulps << " ulp at " << worst.x << ", " << worst.y << ", seed 5eed5eed5eed5eed");
    CHECK(worst.ulps <= 1.0);
  });
}

TEST_CASE("the distance to the twin tells one ulp from two", "[math]") {
  const double x = 0.7;
  const double good = static_cast<double>(wide_sin(static_cast<Wide>(x)));
  if constexpr (kWideIsWider) {
    CHECK(ulps(good, wide_sin(static_cast<Wide>(x))) <= 0.5);
    CHECK(ulps(std::nextafter(std::nextafter(good, 2.0), 2.0), wide_sin(static_cast<Wide>(x))) > 1.0);
  }
  CHECK(ulps(kNan, static_cast<Wide>(1.0)) == kInf);
  CHECK(ulps(1.0, static_cast<Wide>(kInf)) == kInf);
}

TEST_CASE("the same arguments give the same bits in every build", "[math]") {
  struct Row {
    const char* name;
    std::uint64_t got;
    std::uint64_t expected;
  };
  const Row rows[] = {
      {"sin", fingerprint([](double x, double) { return sin(x); }), 0x4a74a390d8750548u},
      {"cos", fingerprint([](double x, double) { return cos(x); }), 0xd0ec998f96718f8eu},
      {"sincos.sin", fingerprint([](double x, double) { return sincos(x).sin; }), 0x4a74a390d8750548u},
      {"sincos.cos", fingerprint([](double x, double) { return sincos(x).cos; }), 0xd0ec998f96718f8eu},
      {"tan", fingerprint([](double x, double) { return tan(x); }), 0xb9f1cfb0a695a9c0u},
      {"asin", fingerprint([](double, double y) { return asin(y); }), 0xa86ba2f90d62c45du},
      {"acos", fingerprint([](double, double y) { return acos(y); }), 0xce378ee4ba6b8064u},
      {"atan", fingerprint([](double x, double) { return atan(x); }), 0xae38ac04513edfe3u},
      {"atan2", fingerprint([](double x, double y) { return atan2(y, x); }), 0x16b8068313abc182u},
      {"exp", fingerprint([](double x, double) { return exp(x); }), 0x4c25fccb9275c99eu},
      {"log", fingerprint([](double x, double) { return log(x); }), 0xf091c755b5d964e5u},
      {"hypot", fingerprint([](double x, double y) { return hypot(x, y); }), 0x90a4447c2e8eb1cbu},
  };
  for (const Row& row : rows) {
    char got[32];
    std::snprintf(got, sizeof(got), "0x%016" PRIx64, row.got);
    INFO(row.name << " gives " << got);
    CHECK(row.got == row.expected);
  }
}

TEST_CASE("a fingerprint sees the last bit of one value in 24000", "[math]") {
  int calls = 0;
  const std::uint64_t right = fingerprint([](double x, double) { return sin(x); });
  const std::uint64_t wrong = fingerprint(
      [&calls](double x, double) { return ++calls == 7777 ? std::nextafter(sin(x), 2.0) : sin(x); });
  CHECK(right != wrong);
}

TEST_CASE("sine, cosine and tangent keep their promises at the edges", "[math]") {
  for (const double bad : {kInf, -kInf, kNan, -kNan}) {
    CHECK(is_the_nan(sin(bad)));
    CHECK(is_the_nan(cos(bad)));
    CHECK(is_the_nan(tan(bad)));
    CHECK(is_the_nan(sincos(bad).sin));
    CHECK(is_the_nan(sincos(bad).cos));
  }
  for (const double x : {0.0, -0.0, kSmallest, -kSmallest, 1e-300, -1e-9}) {
    CHECK(same(sin(x), x));
    CHECK(same(tan(x), x));
    CHECK(cos(x) == 1.0);
  }
  // Values to 20 digits from arbitrary-precision arithmetic.
  CHECK(sin(1e22) == -0.85220084976718880177);
  CHECK(cos(1e22) == 0.52321478539513894550);
  CHECK(sin(kLargest) == 0.0049619547891840617905);
  CHECK(cos(kLargest) == -0.99998768942655991136);
  CHECK(sin(kRoundedPi) == 1.2246467991473531772e-16);
  CHECK(cos(0.5 * kRoundedPi) == 6.1232339957367658862e-17);
  // The double that comes nearest to a multiple of pi/2.
  CHECK(cos(0x1.6ac5b262ca1ffp+849) == -4.6871659242546276111e-19);
  CHECK(tan(0.5 * kRoundedPi) == 16331239353195369.756);
}

TEST_CASE("sine is odd, cosine is even, and squares add up to one", "[math]") {
  Random random(0xabcdef0123456789u);
  for (int i = 0; i < 20000; ++i) {
    const double x = i % 2 == 0 ? random.within(1e4) : random.any();
    INFO("x = " << x << ", seed abcdef0123456789");
    REQUIRE(same(sin(-x), -sin(x)));
    REQUIRE(same(cos(-x), cos(x)));
    REQUIRE(same(tan(-x), -tan(x)));
    REQUIRE(std::fabs(sin(x) * sin(x) + cos(x) * cos(x) - 1.0) < 5e-16);
    REQUIRE(same(sincos(x).sin, sin(x)));
    REQUIRE(same(sincos(x).cos, cos(x)));
  }
}

TEST_CASE("arc functions keep their promises at the edges", "[math]") {
  for (const double bad : {1.0 + 0x1p-52, -1.0 - 0x1p-52, 2.0, kInf, -kInf, kNan}) {
    CHECK(is_the_nan(asin(bad)));
    CHECK(is_the_nan(acos(bad)));
  }
  CHECK(asin(1.0) == 0.5 * kRoundedPi);
  CHECK(asin(-1.0) == -0.5 * kRoundedPi);
  CHECK(same(asin(-0.0), -0.0));
  CHECK(same(asin(kSmallest), kSmallest));
  CHECK(same(acos(1.0), 0.0));
  CHECK(acos(-1.0) == kRoundedPi);
  CHECK(acos(0.0) == 0.5 * kRoundedPi);
  CHECK(is_the_nan(atan(kNan)));
  CHECK(atan(kInf) == 0.5 * kRoundedPi);
  CHECK(atan(-kInf) == -0.5 * kRoundedPi);
  CHECK(same(atan(-0.0), -0.0));
  CHECK(same(atan(kSmallest), kSmallest));
}

TEST_CASE("atan2 is the angle of a direction, however far away the point is", "[math]") {
  constexpr std::uint32_t kSeed = 29;
  INFO("seed " << kSeed);
  std::mt19937 random(kSeed);
  const auto part = [&random] {
    return (random() % 2 == 0 ? 1.0 : -1.0) * (1.0 + static_cast<double>(random()) * 0x1p-32);
  };
  for (int i = 0; i < 2000; ++i) {
    const double y = part();
    const double x = part() * (i % 3 == 0 ? 0x1p-3 : 1.0);
    const double near = atan2(y, x);
    for (const double scale : {0x1p1023, 0x1p1000, 0x1p501, 0x1p-401, 0x1p-1000})
      REQUIRE(same(atan2(y * scale, x * scale), near));
  }
}

TEST_CASE("atan2 treats zeros and infinities as directions with signs", "[math]") {
  CHECK(same(atan2(0.0, 0.0), 0.0));
  CHECK(same(atan2(-0.0, 0.0), -0.0));
  CHECK(same(atan2(0.0, -0.0), kRoundedPi));
  CHECK(same(atan2(-0.0, -0.0), -kRoundedPi));
  CHECK(same(atan2(-0.0, -1.0), -kRoundedPi));
  CHECK(same(atan2(0.0, 5.0), 0.0));
  CHECK(atan2(1.0, -0.0) == 0.5 * kRoundedPi);
  CHECK(atan2(-1.0, 0.0) == -0.5 * kRoundedPi);
  CHECK(atan2(kInf, kInf) == 0.25 * kRoundedPi);
  CHECK(atan2(kInf, -kInf) == 0x1.2d97c7f3321d2p+1);
  CHECK(atan2(-kInf, -kInf) == -0x1.2d97c7f3321d2p+1);
  CHECK(atan2(kInf, 1.0) == 0.5 * kRoundedPi);
  CHECK(same(atan2(-1.0, kInf), -0.0));
  CHECK(atan2(-1.0, -kInf) == -kRoundedPi);
  CHECK(is_the_nan(atan2(kNan, kInf)));
  CHECK(is_the_nan(atan2(0.0, kNan)));
  CHECK(same(atan2(kSmallest, 1.0), kSmallest));
  CHECK(same(atan2(kSmallest, kLargest), 0.0));
  CHECK(atan2(kLargest, kSmallest) == 0.5 * kRoundedPi);
  CHECK(atan2(kSmallest, kSmallest) == 0.25 * kRoundedPi);
  CHECK(atan2(kLargest, -kLargest) == 0.75 * kRoundedPi);
}

TEST_CASE("exp and log keep their promises at the edges", "[math]") {
  CHECK(exp(0.0) == 1.0);
  CHECK(exp(-0.0) == 1.0);
  CHECK(exp(kInf) == kInf);
  CHECK(same(exp(-kInf), 0.0));
  CHECK(is_the_nan(exp(kNan)));
  CHECK(exp(0x1.62e42fefa39efp+9) == 0x1.fffffffffff2ap+1023);
  CHECK(exp(std::nextafter(0x1.62e42fefa39efp+9, kInf)) == kInf);
  CHECK(exp(-0x1.74910d52d3051p+9) == kSmallest);
  CHECK(same(exp(-746.0), 0.0));
  CHECK(same(log(1.0), 0.0));
  CHECK(log(0.0) == -kInf);
  CHECK(log(-0.0) == -kInf);
  CHECK(is_the_nan(log(-kSmallest)));
  CHECK(is_the_nan(log(-kInf)));
  CHECK(is_the_nan(log(kNan)));
  CHECK(log(kInf) == kInf);
  CHECK(log(kSmallest) == -744.44007192138126231);
  CHECK(log(kLargest) == 709.78271289338399684);
}

TEST_CASE("hypot neither overflows nor underflows on the way", "[math]") {
  CHECK(hypot(3.0, -4.0) == 5.0);
  CHECK(hypot(3e300, 4e300) == 5e300);
  CHECK(hypot(3.0 * kSmallest, 4.0 * kSmallest) == 5.0 * kSmallest);
  CHECK(hypot(kLargest, kLargest) == kInf);
  CHECK(same(hypot(-0.0, -0.0), 0.0));
  CHECK(hypot(-7.0, 0.0) == 7.0);
  CHECK(hypot(kInf, kNan) == kInf);
  CHECK(hypot(kNan, -kInf) == kInf);
  CHECK(is_the_nan(hypot(kNan, 1.0)));
  CHECK(hypot(1.0, 1e-30) == 1.0);
}

TEST_CASE("floor is the library's, of every kind of number", "[math]") {
  const std::uint64_t seed = std::random_device{}();
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  std::size_t wrong = 0;
  for (int i = 0; i < 100000; ++i) {
    const std::uint64_t bits = random();
    const double any = std::bit_cast<double>(bits);
    // Where whole numbers and halves of them lie.
    const double near = std::ldexp(static_cast<double>(static_cast<std::int64_t>(bits) >> (bits % 60)), -1);
    for (const double x : {any, near, std::nextafter(near, 1e300), std::nextafter(near, -1e300)}) {
      if (x == x && !same(floor(x), std::floor(x))) ++wrong;
    }
  }
  CHECK(wrong == 0);
  CHECK(same(floor(-0.0), -0.0));
  CHECK(same(floor(0.0), 0.0));
  CHECK(floor(-kSmallest) == -1.0);
  CHECK(floor(-kInf) == -kInf);
  CHECK(floor(kNan) != floor(kNan));
}

TEST_CASE("the arithmetic check notices another rounding direction", "[math]") {
  CHECK(arithmetic_is_strict());
  if (std::fesetround(FE_UPWARD) == 0) {
    const bool strict = arithmetic_is_strict();
    std::fesetround(FE_TONEAREST);
    CHECK_FALSE(strict);
  }
  CHECK(arithmetic_is_strict());
}

}  // namespace sortie::rt::test
