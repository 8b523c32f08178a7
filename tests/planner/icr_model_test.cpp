// SPDX-License-Identifier: BSD-3-Clause
// The turning-centre model against rigid-body motion, both ways.
#include "planner/icr_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

namespace {
using namespace sortie::planner;

struct Place {
  double x, y;
};

/// Velocity of a point of the rigid body: v + w x p.
Place velocity(const Twist& twist, const Place& p) {
  return {twist.v_x_m_s - twist.w_rad_s * p.y, twist.v_y_m_s + twist.w_rad_s * p.x};
}
}  // namespace

TEST_CASE("Each belt is as fast as the body there where the track turns, and the turning centre stands") {
  std::mt19937_64 random(6);
  const auto draw = [&random](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 20'000; ++i) {
    const IcrModel model{draw(-0.2, 0.2), draw(0.05, 0.8), draw(-0.8, -0.05)};
    const TrackSpeeds tracks{draw(-1, 1), draw(-1, 1)};
    const Twist twist = model.to_twist(tracks);
    // At (x, y_left) the body moves forward as fast as the left belt and not sideways; so at the right.
    const Place left = velocity(twist, {model.x_m, model.y_left_m});
    const Place right = velocity(twist, {model.x_m, model.y_right_m});
    REQUIRE(left.x == Approx(tracks.left_m_s).margin(1e-13));
    REQUIRE(right.x == Approx(tracks.right_m_s).margin(1e-13));
    REQUIRE(left.y == Approx(0).margin(1e-13));
    REQUIRE(right.y == Approx(0).margin(1e-13));
    if (std::fabs(twist.w_rad_s) > 1e-3) {  // the centre of rotation does not move
      const Place centre{model.x_m, twist.v_x_m_s / twist.w_rad_s};
      const Place still = velocity(twist, centre);
      REQUIRE(still.x == Approx(0).margin(1e-12));
      REQUIRE(still.y == Approx(0).margin(1e-12));
    }
    const TrackSpeeds back = model.to_tracks(twist.v_x_m_s, twist.w_rad_s);
    REQUIRE(back.left_m_s == Approx(tracks.left_m_s).margin(1e-13));
    REQUIRE(back.right_m_s == Approx(tracks.right_m_s).margin(1e-13));
    const double most = std::fabs(twist.v_x_m_s) + model.lever_m() * std::fabs(twist.w_rad_s);
    REQUIRE(std::max(std::fabs(back.left_m_s), std::fabs(back.right_m_s)) <= most + 1e-13);
  }
}

TEST_CASE("A belt's path over time is a circle of the radius that the model says") {
  const IcrModel model = IcrModel::from_efficiency(0.4, 0.65, -0.03, 0.02);
  const Twist twist = model.to_twist({0.2, 0.35});
  // Integrated in small steps of the body's own twist, the origin goes round a circle of radius
  // |v| / |w| and is back after one turn.
  double x = 0, y = 0, heading = 0, far = 0;
  const int steps = 200'000;
  const double turn_s = 2.0 * 3.14159265358979323846 / twist.w_rad_s;
  for (int i = 0; i < steps; ++i) {
    const double dt = turn_s / steps;
    const double middle = heading + 0.5 * twist.w_rad_s * dt;
    x += dt * (twist.v_x_m_s * std::cos(middle) - twist.v_y_m_s * std::sin(middle));
    y += dt * (twist.v_x_m_s * std::sin(middle) + twist.v_y_m_s * std::cos(middle));
    heading += twist.w_rad_s * dt;
    far = std::max(far, std::sqrt(x * x + y * y));
  }
  CHECK(std::sqrt(x * x + y * y) < 1e-6);
  const double radius =
      std::sqrt(twist.v_x_m_s * twist.v_x_m_s + twist.v_y_m_s * twist.v_y_m_s) / twist.w_rad_s;
  CHECK(far == Approx(2.0 * radius).epsilon(1e-6));
}

TEST_CASE("Efficiency 1 is the differential drive, and a lower one turns less for the same belts") {
  const Twist ideal = IcrModel::from_efficiency(0.4, 1.0).to_twist({-0.2, 0.2});
  CHECK(ideal.w_rad_s == Approx(1.0));
  CHECK(ideal.v_x_m_s == 0.0);
  const Twist real = IcrModel::from_efficiency(0.4, 0.65).to_twist({-0.2, 0.2});
  CHECK(real.w_rad_s == Approx(0.65));
  // Centres that lie off the middle: a turn of the belts on the spot moves the body forward.
  const Twist uneven = IcrModel::from_efficiency(0.4, 1.0, 0.0, 0.1).to_twist({-0.2, 0.2});
  CHECK(uneven.v_x_m_s == Approx(0.1));
}
