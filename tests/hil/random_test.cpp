// SPDX-License-Identifier: BSD-3-Clause
// The random numbers of the test bench: known sequence, independence of streams, moments.
#include "hil/random.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

using sortie::hil::Random;

TEST_CASE("the generator continues the published sequence of xoshiro256**") {
  Random random = Random::from_state(1, 2, 3, 4);
  const std::uint64_t expected[] = {11520u, 0u, 1509978240u, 1215971899390074240u};
  for (const std::uint64_t value : expected) CHECK(random.bits() == value);
}

TEST_CASE("SplitMix64 gives the published numbers") {
  std::uint64_t state = 1234567;
  CHECK(sortie::hil::splitmix64(state) == 6457827717110365317u);
  CHECK(sortie::hil::splitmix64(state) == 3203168211198807973u);
}

TEST_CASE("uniform numbers fill their interval evenly and stay in it") {
  Random random(42);
  constexpr int kDraws = 200000;
  std::vector<int> bins(20);
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    REQUIRE(u >= 0.0);
    REQUIRE(u < 1.0);
    ++bins[static_cast<std::size_t>(u * 20.0)];
  }
  double chi2 = 0.0;
  for (const int count : bins) {
    const double expected = kDraws / 20.0;
    chi2 += (count - expected) * (count - expected) / expected;
  }
  CHECK(chi2 < 43.8);  // 99.9 % of chi-square with 19 degrees of freedom
  CHECK(chi2 > 5.4);   // 0.1 %: evener than chance is no chance either
}

TEST_CASE("normal numbers have the moments and the tails of a normal distribution") {
  Random random(7);
  constexpr int kDraws = 400000;
  double sum = 0.0;
  double sum2 = 0.0;
  double sum3 = 0.0;
  double sum4 = 0.0;
  double neighbours = 0.0;
  double last = 0.0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = random.normal();
    sum += x;
    sum2 += x * x;
    sum3 += x * x * x;
    sum4 += x * x * x * x;
    neighbours += x * last;
    last = x;
    beyond_two += std::fabs(x) > 2.0 ? 1 : 0;
  }
  const double n = kDraws;
  const double root = std::sqrt(n);
  CHECK(std::fabs(sum / n) < 4.0 / root);
  CHECK(std::fabs(sum2 / n - 1.0) < 4.0 * std::sqrt(2.0) / root);
  CHECK(std::fabs(sum3 / n) < 4.0 * std::sqrt(15.0) / root);
  CHECK(std::fabs(sum4 / n - 3.0) < 4.0 * std::sqrt(96.0) / root);
  CHECK(std::fabs(neighbours / n) < 4.0 / root);
  CHECK(std::fabs(beyond_two / n - 0.0455003) < 4.0 * std::sqrt(0.0455 * 0.9545) / root);
}

TEST_CASE("streams of one seed and seeds of one stream have nothing in common") {
  constexpr int kDraws = 20000;
  for (const auto& [a_seed, a_stream, b_seed, b_stream] :
       {std::array<std::uint64_t, 4>{1, 0, 1, 1}, {1, 0, 2, 0}, {5, 7, 7, 5}, {0, 0, 0, 1u << 24}}) {
    Random a(a_seed, a_stream);
    Random b(b_seed, b_stream);
    double product = 0.0;
    for (int i = 0; i < kDraws; ++i) {
      const double x = a.normal();
      const double y = b.normal();
      product += x * y;
    }
    CHECK(std::fabs(product / kDraws) < 4.0 / std::sqrt(static_cast<double>(kDraws)));
  }
}
