// SPDX-License-Identifier: BSD-3-Clause
// Where a skid-steered vehicle turns about, and what that does to its way.
#include "estimators/turning_centre.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/estimators/odometry_samples.hpp"

namespace {

using namespace sortie::estimators::test;
using sortie::estimators::TrackProfile;

/// Half of the load of a linear pressure lies behind it: by adding up slices.
double median_by_slices(double half_length_m, double com_x_m) {
  constexpr int kSlices = 200'000;
  const double width = 2.0 * half_length_m / kSlices;
  double load = 0.0;
  for (int i = 0; i < kSlices; ++i) {
    const double x = -half_length_m + (i + 0.5) * width;
    load += width * (1.0 + 3.0 * com_x_m * x / (half_length_m * half_length_m)) / (2.0 * half_length_m);
    if (load >= 0.5) return x;
  }
  return half_length_m;
}

}  // namespace

TEST_CASE("The turning centre is the median of the load") {
  TrackProfile profile;
  profile.half_length_m = 0.25;
  for (const double com : {-0.08, -0.057, -0.01, 0.0, 1e-9, 0.03, 0.0833}) {
    profile.com_x_m = com;
    CHECK(sortie::estimators::turning_centre_x_m(profile) ==
          Approx(median_by_slices(0.25, com)).margin(1e-5));
  }
  profile.com_x_m = 0.2;  // one end carries all; the limit
  CHECK(sortie::estimators::turning_centre_x_m(profile) ==
        Approx(median_by_slices(0.25, 0.25 / 3)).margin(1e-5));
}

TEST_CASE("A body that turns about a point behind it moves on a circle about that point") {
  using namespace sortie;
  for (const bool obstacles : {false, true}) {
    estimators::TrackOdometryConfig config;
    config.icr_x_m = -0.08;
    config.obstacles = obstacles;
    estimators::TrackOdometry odometry(config);
    double heading = 0.0;
    for (int i = 0; i <= 400; ++i) {
      const rt::Nanoseconds now = 10 * kMs * (i + 1);
      REQUIRE(odometry.observe(attitude_at(now, rt::from_yaw_pitch_roll(heading, 0, 0), {0, 0, 0.5})) ==
              Status::ok);
      const double belt = 0.2 * heading;
      REQUIRE(odometry.update({now, -belt, belt, 0}) == Status::ok);
      // The centre, 8 cm behind, stays at (-0.08, 0).
      const rt::Vector3 p = position_of(odometry);
      CHECK(p.x == Approx(-0.08 + 0.08 * std::cos(heading)).margin(1e-5));
      CHECK(p.y == Approx(0.08 * std::sin(heading)).margin(1e-5));
      heading += 0.005;
    }
  }
}

TEST_CASE("A clipped accelerometer is not believed about a fall") {
  using namespace sortie;
  estimators::TrackOdometryConfig config;
  config.obstacles = true;
  estimators::TrackOdometry odometry(config);
  rt::ImuSample imu;
  imu.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
  for (int i = 0; i <= 1000; ++i) {
    const rt::Nanoseconds now = 10 * kMs * (i + 1);
    // Rolling on a plane; at 5 s a blow of 0.6 m/s: it falls by 60 m/s^2 for 10 ms, and what throws it back
    // is clipped at 20 m/s^2 above rest.
    imu.stamp_ns = now;
    imu.acc_m_s2[2] = i == 500 ? -50.19 : i == 501 ? 29.81 : 9.81;
    if (i == 501) imu.flags |= rt::kImuSaturated;
    REQUIRE(odometry.observe(attitude_at(now, {}, {})) == Status::ok);
    odometry.feel(imu);
    imu.flags &= ~std::uint32_t{rt::kImuSaturated};
    REQUIRE(odometry.update({now, 0.002 * i, 0.002 * i, 0}) == Status::ok);
  }
  CHECK(std::fabs(position_of(odometry).z) < 0.02);
}
