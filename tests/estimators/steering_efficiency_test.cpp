// SPDX-License-Identifier: BSD-3-Clause
// The efficiency of skid steering is learned from the gyro; the heading is the gyro's whatever tracks claim.
#include "estimators/steering_efficiency.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/estimators/odometry_samples.hpp"

namespace {

using namespace sortie::estimators::test;
using sortie::estimators::SteeringConfig;
using sortie::estimators::SteeringEfficiency;

/// Drives arcs for a minute; tracks claim 1 / chi times the turn.
sortie::estimators::TrackOdometry turns(double chi) {
  using namespace sortie;
  estimators::TrackOdometryConfig config;
  config.track_width_m = 0.4;
  config.learn_steering = true;
  config.obstacles = true;
  estimators::TrackOdometry odometry(config);
  double heading = 0, left = 0, right = 0;
  for (int i = 0; i <= 6000; ++i) {
    const double rate = i % 2000 < 1000 ? 0.4 : -0.3;
    const rt::Nanoseconds now = 10 * kMs * (i + 1);
    REQUIRE(odometry.observe(attitude_at(now, rt::from_yaw_pitch_roll(heading, 0, 0), {0, 0, rate})) ==
            Status::ok);
    REQUIRE(odometry.update({now, left, right, 0}) == Status::ok);
    heading += 0.01 * rate;
    left += 0.01 * (0.2 - 0.2 * rate / chi);
    right += 0.01 * (0.2 + 0.2 * rate / chi);
  }
  return odometry;
}

}  // namespace

TEST_CASE("The steering efficiency is found within a minute, and changes with the ground") {
  SteeringConfig config;
  config.track_width_m = 0.4;
  SteeringEfficiency steering(config);
  const auto drive = [&](double chi, double seconds) {
    for (double t = 0; t < seconds; t += 0.02) {
      const double asked = 0.5 * std::sin(0.3 * t) * 0.02;
      steering.update(0.02, -0.5 * asked * 0.4, 0.5 * asked * 0.4, chi * asked);
    }
  };
  drive(0.8, 60);
  CHECK(steering.value() == Approx(0.8).margin(0.01));
  CHECK(steering.centres_apart_m() == Approx(0.5).margin(0.01));
  drive(0.5, 300);
  CHECK(steering.value() == Approx(0.5).margin(0.02));
  CHECK(steering.expected_rad(0.0, 0.4) == Approx(0.5).margin(0.02));
}

TEST_CASE("Tracks that claim seven times the true turn are not believed: the pose is the gyro's") {
  const sortie::estimators::TrackOdometry honest = turns(0.9);
  const sortie::estimators::TrackOdometry wild = turns(1.0 / 7.0);
  CHECK(honest.steering().value() == Approx(0.9).margin(0.02));
  CHECK(honest.steering().trusted());
  CHECK(wild.steering().value() == Approx(1.0 / 7.0).margin(0.02));
  CHECK_FALSE(wild.steering().trusted());
  CHECK(norm(position_of(honest) - position_of(wild)) < 1e-9);
  CHECK(wild.counters().slips < 60);  // until it is learned
}
