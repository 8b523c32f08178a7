// SPDX-License-Identifier: BSD-3-Clause
// Drives and suspension against closed forms and fine numerical integration.
#include "hil/track_drive.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hil/random.hpp"
#include "hil/suspension.hpp"

using namespace sortie::hil;

namespace {

/// Speed and travel of the lag with limited acceleration by 20000 midpoint steps.
struct Fine {
  double speed{};
  double travel{};
  void advance(double target, double lag, double limit, double span) {
    constexpr int kSteps = 20000;
    const double h = span / kSteps;
    const auto rate = [&](double u) { return std::fmin(std::fmax((target - u) / lag, -limit), limit); };
    for (int i = 0; i < kSteps; ++i) {
      const double middle = speed + 0.5 * h * rate(speed);
      travel += h * middle;
      speed += h * rate(middle);
    }
  }
};

}  // namespace

TEST_CASE("an unlimited drive follows the exponential") {
  TrackDrive drive(0.1, 1e9, 0.001);
  for (int i = 0; i < 700; ++i) drive.advance(0.5);
  const double decay = std::exp(-7.0);
  CHECK(drive.speed_m_s() == Approx(0.5 * (1.0 - decay)).epsilon(1e-12));
  CHECK(drive.travel_m() == Approx(0.5 * (0.7 - 0.1 * (1.0 - decay))).epsilon(1e-12));
}

TEST_CASE("a limited drive follows the equation through ramp, knee and reversal") {
  Random random(3);
  TrackDrive drive(0.08, 2.0, 0.02);
  Fine fine;
  for (int i = 0; i < 60; ++i) {
    const double target = random.uniform(-0.8, 0.8);
    drive.advance(target);
    fine.advance(target, 0.08, 2.0, 0.02);
    REQUIRE(drive.speed_m_s() == Approx(fine.speed).margin(1e-8));
    REQUIRE(drive.travel_m() == Approx(fine.travel).margin(1e-8));
  }
}

TEST_CASE("the answer of a drive does not depend on the step") {
  TrackDrive coarse(0.05, 1.5, 0.2);
  TrackDrive fine(0.05, 1.5, 0.001);
  for (int i = 0; i < 10; ++i) {
    const double target = i % 2 == 0 ? 0.6 : -0.3;
    coarse.advance(target);
    for (int k = 0; k < 200; ++k) fine.advance(target);
    REQUIRE(coarse.speed_m_s() == Approx(fine.speed_m_s()).margin(1e-13));
    REQUIRE(coarse.travel_m() == Approx(fine.travel_m()).margin(1e-13));
  }
}

TEST_CASE("the suspension is the critically damped step response, and comes to rest") {
  Suspension suspension(4.0, 0.001);
  suspension.reset(0.0);
  const double w = 2.0 * 3.14159265358979323846 * 4.0;
  for (int i = 1; i <= 2000; ++i) {
    suspension.advance(0.3);
    const double t = 0.001 * i;
    REQUIRE(suspension.value() == Approx(0.3 * (1.0 - (1.0 + w * t) * std::exp(-w * t))).margin(1e-13));
    REQUIRE(suspension.rate() == Approx(0.3 * w * w * t * std::exp(-w * t)).margin(1e-12));
  }
  CHECK(suspension.value() == Approx(0.3).epsilon(1e-12));
}
