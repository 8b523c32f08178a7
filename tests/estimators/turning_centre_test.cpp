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

TEST_CASE("A height that is put right is no motion") {
  using namespace sortie;
  estimators::TrackOdometryConfig config;
  config.obstacles = true;
  estimators::TrackOdometry odometry(config);
  double travel_m = 0.0;
  double nose_up = 0.0;
  rt::Vector3 v_before;
  double mended_m = 0.0;
  double fastest_m_s = 0.0;
  for (int i = 1; i <= 3000; ++i) {
    // Level; from 5 s on it rocks about an edge while it drives, and stands still from 20 s on. The
    // accelerometer is off along all axes.
    const double t = 0.01 * i;
    const double w = t > 5.0 && t <= 20.0 ? 0.5 * rt::sincos(2.0 * (t - 5.0)).sin : 0.0;
    const double speed = 0.3 * std::clamp(std::min(t - 1.0, 20.0 - t), 0.0, 1.0);
    nose_up += 0.01 * w;
    travel_m += 0.01 * speed;
    const rt::Quaternion q = rt::from_yaw_pitch_roll(0, -nose_up, 0);
    rt::ImuSample imu;
    imu.stamp_ns = 10 * kMs * i;
    imu.flags = rt::kImuGyr | rt::kImuAcc | rt::kImuMeanRate;
    const rt::Vector3 v = rotate(q, {speed, 0, 0});
    const rt::Vector3 force = 100.0 * (v - v_before) + rt::Vector3{0, 0, 9.81};
    v_before = v;
    rt::store(rotate_back(q, force) + rt::Vector3{0.06, 0.06, 0.06}, imu.acc_m_s2);
    const double before_m = position_of(odometry).z;
    REQUIRE(odometry.observe(attitude_at(imu.stamp_ns, q, {0, -w, 0})) == Status::ok);
    odometry.feel(imu);
    REQUIRE(odometry.update({imu.stamp_ns, travel_m, travel_m, 0}) == Status::ok);
    if (t < 20.015) continue;
    mended_m += std::fabs(position_of(odometry).z - before_m);
    fastest_m_s = std::max(fastest_m_s, norm(rt::to_vector(odometry.estimate().v_body_m_s)));
  }
  CAPTURE(mended_m, fastest_m_s);
  CHECK(mended_m > 0.002);
  CHECK(fastest_m_s < 0.03);
}
