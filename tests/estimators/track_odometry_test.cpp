// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning against closed forms and a long-double twin.
#include "estimators/track_odometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "tests/estimators/odometry_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::TrackOdometry;
using estimators::TrackOdometryConfig;

namespace {

/// Smallest eigenvalue's sign by Cholesky in long double: true when the matrix is positive semi-definite (to
/// rounding).
bool positive(const double (&c)[36]) {
  long double l[6][6]{};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j <= i; ++j) {
      if (c[6 * i + j] != c[6 * j + i]) return false;
      long double sum = c[6 * i + j] + (i == j ? 1e-12L : 0.0L);
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && sum <= 0) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  return true;
}

}  // namespace

TEST_CASE("A circle comes out as the closed form has it, whatever the rates of tracks and attitude") {
  for (const rt::Nanoseconds track_step : {10 * kMs, 100 * kMs, 210 * kMs}) {
    for (const rt::Nanoseconds attitude_step : {5 * kMs, 33 * kMs}) {
      constexpr double kSpeed = 0.7;
      constexpr double kTurn = 0.9;
      TrackOdometry odometry{TrackOdometryConfig{}};
      rt::Nanoseconds attitude_time = 0;
      rt::Nanoseconds now = 0;
      for (; now <= 20 * rt::kNanosecondsPerSecond; now += track_step) {
        for (; attitude_time <= now; attitude_time += attitude_step) {
          const Quaternion q = rt::from_yaw_pitch_roll(kTurn * rt::to_seconds(attitude_time), 0, 0);
          REQUIRE(odometry.observe(attitude_at(attitude_time, q, {0, 0, kTurn})) == Status::ok);
        }
        const double way = kSpeed * rt::to_seconds(now);
        REQUIRE(odometry.update({now, way - 0.2 * kTurn * rt::to_seconds(now),
                                 way + 0.2 * kTurn * rt::to_seconds(now), 0}) == Status::ok);
        const double angle = kTurn * rt::to_seconds(now);
        const double radius = kSpeed / kTurn;
        const Vector3 truth{radius * std::sin(angle), radius * (1 - std::cos(angle)), 0};
        INFO("tracks every " << track_step / kMs << " ms, attitude every " << attitude_step / kMs << " ms");
        REQUIRE(norm(position_of(odometry) - truth) < 2e-6);
        REQUIRE(norm(log_rotation(conjugate(rt::to_quaternion(odometry.estimate().q_world_body)) *
                                  rt::from_yaw_pitch_roll(angle, 0, 0))) < 1e-12);
      }
      CHECK(odometry.estimate().v_body_m_s[0] == Approx(kSpeed));
      CHECK(odometry.estimate().w_body_rad_s[2] == Approx(kTurn));
      CHECK(odometry.counters().attitude_stale == 0);
    }
  }
}

TEST_CASE("On a slope the way leads up, and configured pose, heading and scales count") {
  TrackOdometryConfig config;
  config.p_world_body_m[0] = 5;
  config.p_world_body_m[2] = 1;
  config.heading_offset_rad = kPi / 2;
  config.scale_left = 1.1;
  config.scale_right = 0.9;
  TrackOdometry odometry(config);
  const double slope = 0.3;
  const Quaternion q = rt::from_yaw_pitch_roll(0, -slope, 0);  // nose up
  for (int i = 0; i <= 100; ++i) {
    REQUIRE(odometry.observe(attitude_at(i * 20 * kMs, q, {})) == Status::ok);
    REQUIRE(odometry.update({i * 20 * kMs, 0.01 * i, 0.01 * i, 0}) == Status::ok);
  }
  const Vector3 p = position_of(odometry);
  CHECK(p.x == Approx(5));
  CHECK(p.y == Approx(std::cos(slope)));
  CHECK(p.z == Approx(1 + std::sin(slope)));
  CHECK(odometry.estimate().distance_m == Approx(1.0));
}

TEST_CASE("A random drive over rough ground agrees with a long-double twin") {
  std::mt19937 random(8);
  const auto angles = [](double t) {
    return Vector3{0.8 * std::sin(0.7 * t) + 0.1 * t, 0.3 * std::sin(1.1 * t), 0.2 * std::cos(0.9 * t)};
  };
  const auto attitude = [&](double t) {
    const Vector3 a = angles(t);
    return rt::from_yaw_pitch_roll(a.x, a.y, a.z);
  };
  TrackOdometry odometry{TrackOdometryConfig{}};
  rt::Nanoseconds imu = 0;
  rt::Nanoseconds now = 0;
  long double x = 0, y = 0, z = 0;
  double way = 0;
  for (int i = 0; i < 400; ++i) {
    for (; imu <= now; imu += 10 * kMs) {
      const double t = rt::to_seconds(imu);
      const Vector3 w = 1e6 * log_rotation(conjugate(attitude(t - 5e-7)) * attitude(t + 5e-7));
      REQUIRE(odometry.observe(attitude_at(imu, attitude(t), w)) == Status::ok);
    }
    REQUIRE(odometry.update({now, way, way, 0}) == Status::ok);
    const Vector3 twin{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    REQUIRE(norm(position_of(odometry) - twin) < 2e-3 * (0.05 + way / 40));
    const rt::Nanoseconds step = 40 * kMs + static_cast<rt::Nanoseconds>(random() % 80) * kMs;
    const double speed = 0.01 * static_cast<double>(random() % 100);
    constexpr int kPieces = 100;
    for (int k = 0; k < kPieces; ++k) {
      const double t = rt::to_seconds(now) + rt::to_seconds(step) * (k + 0.5) / kPieces;
      const Vector3 f = rotate(attitude(t), {1, 0, 0});
      const long double d = static_cast<long double>(speed) * rt::to_seconds(step) / kPieces;
      x += d * f.x;
      y += d * f.y;
      z += d * f.z;
    }
    way += speed * rt::to_seconds(step);
    now += step;
  }
  CHECK(way > 10);
}

TEST_CASE(
    "The covariance grows with the way and the turn, stays symmetric and positive, and keeps the tilt "
    "bounded") {
  TrackOdometry odometry{TrackOdometryConfig{}};
  double last_x = 0;
  for (int i = 0; i <= 5000; ++i) {
    const rt::Nanoseconds now = i * 20 * kMs;
    REQUIRE(odometry.observe(attitude_at(now, rt::from_yaw_pitch_roll(0, 0, 0), {})) == Status::ok);
    REQUIRE(odometry.update({now, 0.01 * i, 0.01 * i, 0}) == Status::ok);
    REQUIRE(variance(odometry, 0) >= last_x);
    last_x = variance(odometry, 0);
    if (i % 500 == 0) REQUIRE(positive(odometry.estimate().covariance));
  }
  const estimators::PoseCovarianceConfig model;
  CHECK(variance(odometry, 0) == Approx(model.along_m2_per_m * 50).epsilon(0.01));
  // Straight on, heading noise q per second over T at speed v gives a lateral variance of q v^2 T^3 / 3.
  const double lateral = model.lateral_m2_per_m * 50 + model.heading_rad2_per_s * 0.25 * 1e6 / 3;
  CHECK(variance(odometry, 1) == Approx(lateral).epsilon(0.01));
  CHECK(variance(odometry, 3) == Approx(model.tilt_sigma_rad * model.tilt_sigma_rad).epsilon(0.01));
  CHECK(variance(odometry, 5) == Approx(model.heading_rad2_per_s * 100).epsilon(0.01));
  CHECK(odometry.estimate().covariance[6 * 1 + 5] >
        0);  // heading to the left and position to the left go together

  TrackOdometry turning{TrackOdometryConfig{}};
  for (int i = 0; i <= 1000; ++i) {
    const rt::Nanoseconds now = i * 20 * kMs;
    REQUIRE(turning.observe(attitude_at(now, rt::from_yaw_pitch_roll(0.01 * i, 0.1, 0.2), {})) == Status::ok);
    REQUIRE(turning.update({now, 0.01 * i, 0.01 * i, 0}) == Status::ok);
    REQUIRE(positive(turning.estimate().covariance));
  }
  CHECK(variance(turning, 5) > model.heading_rad2_per_rad * 9);
}

TEST_CASE("An uncertain heading stays about the world's up axis while the robot rolls and pitches") {
  TrackOdometryConfig config;
  config.covariance.tilt_sigma_rad = 0;
  config.covariance.heading_rad2_per_rad = 0;
  config.covariance.heading_rad2_per_s = 1e-4;
  TrackOdometry odometry(config);
  for (int i = 0; i <= 200; ++i) {
    const double roll = 1.2 * std::sin(0.05 * i);
    const double pitch = 0.8 * std::sin(0.08 * i);
    const rt::Nanoseconds now = i * 50 * kMs;
    REQUIRE(odometry.observe(attitude_at(now, rt::from_yaw_pitch_roll(0.3, pitch, roll), {})) == Status::ok);
    REQUIRE(odometry.update({now, 0, 0, 0}) == Status::ok);
    const Vector3 up = rotate_back(rt::to_quaternion(odometry.estimate().q_world_body), {0, 0, 1});
    const double u[3] = {up.x, up.y, up.z};
    double about_up = 0;
    double trace = 0;
    for (int r = 0; r < 3; ++r) {
      trace += variance(odometry, 3 + r);
      for (int c = 0; c < 3; ++c)
        about_up += u[r] * odometry.estimate().covariance[6 * (3 + r) + 3 + c] * u[c];
    }
    REQUIRE(about_up == Approx(1e-4 * rt::to_seconds(now)));
    REQUIRE(trace == Approx(about_up));
  }
}

TEST_CASE(
    "Monte Carlo: with heading and travel noise of the model's size the covariance is what the ends scatter "
    "by") {
  // Drive a bent way many times with noise as the model states it; compare the scatter of the end with the
  // covariance.
  constexpr int kRuns = 400;
  constexpr int kSteps = 200;
  const estimators::PoseCovarianceConfig model = [] {
    estimators::PoseCovarianceConfig c;
    c.heading_rad2_per_s = 1e-4;
    c.heading_rad2_per_rad = 0;
    c.lateral_m2_per_m = 0;
    c.vertical_m2_per_m = 0;
    c.tilt_sigma_rad = 0;
    return c;
  }();
  TrackOdometryConfig config;
  config.covariance = model;
  std::mt19937 random(12);
  const auto gauss = [&random] {  // sum of 12 uniform numbers
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
    return sum;
  };
  TrackOdometry reference(config);
  double xx = 0, yy = 0, xy = 0;
  for (int run = -1; run < kRuns; ++run) {
    TrackOdometry odometry(config);
    double heading = 0;
    double way = 0;
    for (int i = 0; i <= kSteps; ++i) {
      const rt::Nanoseconds now = i * 100 * kMs;
      const Quaternion q = rt::from_yaw_pitch_roll(heading + 0.01 * i, 0, 0);
      REQUIRE(odometry.observe(attitude_at(now, q, {})) == Status::ok);
      REQUIRE(odometry.update({now, way, way, 0}) == Status::ok);
      way += 0.05;
      if (run >= 0) heading += std::sqrt(model.heading_rad2_per_s * 0.1) * gauss();
      if (run >= 0) way += std::sqrt(model.along_m2_per_m * 0.05) * gauss();
    }
    if (run < 0) {
      reference = odometry;
      continue;
    }
    const Vector3 d = position_of(odometry) - position_of(reference);
    xx += d.x * d.x / kRuns;
    yy += d.y * d.y / kRuns;
    xy += d.x * d.y / kRuns;
  }
  const auto& c = reference.estimate().covariance;
  INFO("xx " << xx << " / " << c[0] << ", yy " << yy << " / " << c[7] << ", xy " << xy << " / " << c[1]);
  CHECK(xx == Approx(c[0]).epsilon(0.25));
  CHECK(yy == Approx(c[7]).epsilon(0.25));
  CHECK(std::fabs(xy - c[1]) < 0.25 * std::sqrt(c[0] * c[7]));
}

TEST_CASE(
    "A wild count is passed over without loss, a counter that starts again is believed at the second "
    "sample") {
  TrackOdometry odometry{TrackOdometryConfig{}};
  const auto feed = [&](int i, double way) {
    REQUIRE(odometry.observe(attitude_at(i * 20 * kMs, {}, {})) == Status::ok);
    return odometry.update({i * 20 * kMs, way, way, 0});
  };
  for (int i = 0; i <= 50; ++i) REQUIRE(feed(i, 5 + 0.01 * i) == Status::ok);
  CHECK(feed(51, 4000.0) == Status::out_of_range);
  CHECK(feed(52, 5.52) == Status::ok);
  CHECK(position_of(odometry).x == Approx(0.52));
  CHECK(odometry.counters().jumps == 1);
  CHECK(odometry.counters().resets == 0);
  const double before = variance(odometry, 0);
  CHECK(feed(53, 0.0) == Status::out_of_range);
  CHECK(feed(54, 0.01) == Status::ok);
  CHECK(feed(55, 0.02) == Status::ok);
  CHECK(position_of(odometry).x == Approx(0.54));  // the travel between 52 and 53 is lost, and said to be
  CHECK(odometry.counters().resets == 1);
  CHECK((odometry.estimate().flags & estimators::kPoseTravelUnknown) != 0);
  CHECK(variance(odometry, 0) > before + 9e-5);
}
