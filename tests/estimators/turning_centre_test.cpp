// SPDX-License-Identifier: BSD-3-Clause
// Where a skid-steered vehicle turns about, and what that does to its way.
#include "estimators/turning_centre.hpp"

#include <algorithm>
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
  for (const bool told : {false, true}) {
    estimators::TrackOdometryConfig config;
    config.obstacles = true;
    estimators::TrackOdometry odometry(config);
    double worst_m = 0.0;
    for (int i = 0; i <= 5000; ++i) {
      // Rolling on a plane, five samples a step. At 5 s a blow downwards for 2 ms; what throws the body back
      // in the step behind is clipped at 20 m/s^2 above rest.
      const rt::Nanoseconds now = 2 * kMs * (i + 1);
      rt::ImuSample imu;
      imu.stamp_ns = now;
      imu.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
      imu.acc_m_s2[2] = i == 2499 ? -140.19 : i == 2501 ? 29.81 : 9.81;
      if (i == 2501 && told) imu.flags |= rt::kImuSaturated;
      REQUIRE(odometry.observe(attitude_at(now, {}, {})) == Status::ok);
      odometry.feel(imu);
      if (i % 5 == 0) REQUIRE(odometry.update({now, 4e-4 * i, 4e-4 * i, 0}) == Status::ok);
      worst_m = std::max(worst_m, std::fabs(position_of(odometry).z));
    }
    if (told) {
      CHECK(worst_m < 0.02);
    } else {
      CHECK(worst_m > 0.02);  // without the flag it looks like a fall
    }
  }
}
