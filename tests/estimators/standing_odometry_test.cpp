// SPDX-License-Identifier: BSD-3-Clause
// A robot that stands does not move, to the last bit, and nothing that came to light meanwhile is lost.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "estimators/attitude.hpp"
#include "tests/estimators/odometry_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::TrackOdometry;
using estimators::TrackOdometryConfig;

namespace {

TrackOdometryConfig skidding() {
  TrackOdometryConfig config;
  config.icr_x_m = -0.08;
  config.track_width_m = 0.4;
  return config;
}

/// Gives an attitude at rest (or not) whose heading wavers, then a track sample; 10 ms a step.
struct Stand {
  TrackOdometry odometry;
  rt::Nanoseconds now{};

  void step(double left_m, double right_m, double heading, bool rests) {
    now += 10 * kMs;
    rt::AttitudeEstimate attitude = attitude_at(now, rt::from_yaw_pitch_roll(heading, 0.1, 0), {0, 0, 0.03});
    if (rests) attitude.flags |= estimators::kAttitudeStands;
    REQUIRE(odometry.observe(attitude) == Status::ok);
    REQUIRE(odometry.update({now, left_m, right_m, 0}) == Status::ok);
  }
};

}  // namespace

TEST_CASE("While belts and attitude stand, the place stays to the last bit and the twist is zero") {
  for (const bool obstacles : {false, true}) {
    TrackOdometryConfig config = skidding();
    config.obstacles = obstacles;
    Stand stand{TrackOdometry(config)};
    for (int i = 0; i < 100; ++i) stand.step(0.005 * i, 0.005 * i, 0.0, false);
    for (int i = 0; i < 30; ++i) stand.step(0.495, 0.495, 0.0, false);
    stand.step(0.495, 0.495, 0.0, true);
    const Vector3 there = position_of(stand.odometry);
    for (int i = 0; i < 1000; ++i) {
      // An encoder between two counts, and a gyro that wavers.
      const double count = i % 3 == 0 ? 0.0005 : 0.0;
      stand.step(0.495 + count, 0.495 - count, 1e-3 * std::sin(0.7 * i), true);
      const rt::PoseEstimate& pose = stand.odometry.estimate();
      CHECK((pose.flags & estimators::kPoseStationary) != 0);
      for (int k = 0; k < 3; ++k) {
        CHECK(pose.v_body_m_s[k] == 0.0);
        CHECK(pose.w_body_rad_s[k] == 0.0);
      }
      const Vector3 here = position_of(stand.odometry);
      REQUIRE(std::memcmp(&here, &there, sizeof(here)) == 0);
    }
    CHECK_FALSE(stand.odometry.belts_run());
  }
}

TEST_CASE("A robot that creeps while its attitude rests gets where it goes") {
  Stand stand{TrackOdometry(skidding())};
  for (int i = 0; i < 50; ++i) stand.step(0.0, 0.0, 0.0, true);
  for (int i = 0; i <= 2000; ++i) stand.step(2e-5 * i, 2e-5 * i, 0.0, true);  // 2 mm/s for 20 s
  const double way = stand.odometry.estimate().distance_m;
  CHECK(way == Approx(0.04).margin(1.1e-3));
  for (int i = 0; i < 10; ++i) stand.step(0.04, 0.04, 0.0, false);
  CHECK(stand.odometry.estimate().distance_m == Approx(0.04).margin(1e-12));
}

TEST_CASE("A height that is put right while the robot stands counts when it moves") {
  TrackOdometryConfig config = skidding();
  config.obstacles = true;
  Stand stands{TrackOdometry(config)};
  Stand plain{TrackOdometry(config)};  // the same, but nobody says that it stands
  const auto step = [](Stand& stand, double travel_m, double force, bool says_so) {
    for (int k = 1; k <= 5; ++k) {
      const rt::ImuSample sample{
          stand.now + k * 2 * kMs, {0, 0, 0}, {0, 0, force}, rt::kImuGyr | rt::kImuAcc};
      stand.odometry.feel(sample);
    }
    stand.step(travel_m, travel_m, 0.0, says_so);
  };
  for (int i = 0; i < 100; ++i) {
    step(stands, 0.005 * i, 9.81, false);
    step(plain, 0.005 * i, 9.81, false);
  }
  for (int i = 0; i < 60; ++i) {
    step(stands, 0.495, 9.81, i > 30);
    step(plain, 0.495, 9.81, false);
  }
  const double there = position_of(stands.odometry).z;
  for (int i = 0; i < 100; ++i) {
    step(stands, 0.495, 10.2, true);
    step(plain, 0.495, 10.2, false);
  }
  CHECK(position_of(stands.odometry).z == there);
  REQUIRE(std::fabs(position_of(plain.odometry).z - there) > 1e-4);
  for (int i = 0; i < 10; ++i) {
    step(stands, 0.495 + 0.005 * i, 9.81, false);
    step(plain, 0.495 + 0.005 * i, 9.81, false);
  }
  CHECK(position_of(stands.odometry).z == Approx(position_of(plain.odometry).z).margin(1e-9));
}

TEST_CASE("A slow turn on the spot is no rest: the belts run, though the body's place stays") {
  for (const double rate : {0.012, 0.02, 0.03}) {
    estimators::Attitude attitude{estimators::AttitudeConfig{}};
    TrackOdometry odometry{skidding()};
    double heading = 0;
    const auto run = [&](double lasts_s, double turn_rad_s) {
      for (int i = 0; i < static_cast<int>(100 * lasts_s); ++i) {
        const rt::Nanoseconds now = attitude.estimate().stamp_ns + 10 * kMs;
        heading += 0.01 * turn_rad_s;
        rt::ImuSample sample{
            now, {0, 0, turn_rad_s}, {0, 0, 9.81}, rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate};
        attitude.set_moving(odometry.belts_run());
        REQUIRE(attitude.update(sample) == Status::ok);
        REQUIRE(odometry.observe(attitude.estimate()) == Status::ok);
        const double belt = std::floor(0.2 * heading / 0.0005) * 0.0005;
        REQUIRE(odometry.update({now, -belt, belt, 0}) == Status::ok);
      }
    };
    run(5, 0.0);
    run(40, rate);
    run(15, 0.1);
    INFO("rate " << rate);
    // Until a belt has left its place the turn is taken for a bias, and less than a fifth of it stays one.
    CHECK(std::fabs(attitude.estimate().bias_rad_s[2]) < 0.2 * rate);
    CHECK(std::fabs(attitude.estimate().delta_heading_rad - heading) < 0.2 * rate * 55);
  }
}
