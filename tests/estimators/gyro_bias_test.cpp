// SPDX-License-Identifier: BSD-3-Clause
// What a single look may do to the gyro's bias.
#include "estimators/gyro_bias.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace sortie;
using estimators::GyroBias;
using Vector = estimators::VectorOf<double>;

TEST_CASE("A look that is far off counts as one at the bound, and no look leads beyond it") {
  constexpr double kMost = 0.05;
  constexpr double kNoise = 1e-4;
  for (const double seen : {0.3, -20.0, 1e9}) {
    GyroBias<double> wild(Vector{0.01, 0, -0.02}, 1e-4);
    GyroBias<double> bounded = wild;
    const Vector row{0, 0.6, 0.8};
    const double here = 0.8 * -0.02;
    static_cast<void>(wild.observe(row, seen, kNoise, kMost));
    static_cast<void>(bounded.observe(row, here + std::copysign(kMost, seen), kNoise, kMost));
    CHECK(wild.value().x == 0.01);
    CHECK(wild.value().y == Approx(bounded.value().y).epsilon(1e-12));
    CHECK(wild.value().z == Approx(bounded.value().z).epsilon(1e-12));
    for (int i = 0; i < 100; ++i) static_cast<void>(wild.observe(row, seen, kNoise, kMost));
    CHECK(std::fabs(wild.value().y) <= kMost);
    CHECK(std::fabs(wild.value().z) <= kMost);
  }
}

TEST_CASE("A turn that was made with an unsure bias is mended by what is learned of the bias later") {
  // 0.5 rad/s too much for 2 s, then that is seen: the heading is to be turned back by what it was off.
  GyroBias<double> bias(Vector{}, 1.0);
  for (int i = 0; i < 200; ++i) bias.integrate(Vector{0, 0, 1}, 0.01, 0.0);
  CHECK(bias.heading_variance() == Approx(4.0));
  const double turn = bias.observe(Vector{0, 0, 1}, 0.5, 1e-9, 10.0);
  CHECK(turn == Approx(-1.0).epsilon(1e-6));
  CHECK(bias.value().z == Approx(0.5).epsilon(1e-6));
  CHECK(bias.heading_variance() == Approx(0.0).margin(1e-6));
}
