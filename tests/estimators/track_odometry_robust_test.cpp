// SPDX-License-Identifier: BSD-3-Clause
// Dead reckoning when the tracks stand or slip, and against samples that no encoder should send.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "estimators/attitude_config.hpp"
#include "tests/estimators/odometry_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::TrackOdometry;
using estimators::TrackOdometryConfig;

TEST_CASE("Standing still is seen, slip is seen, and slip makes the pose less certain") {
  TrackOdometryConfig config;
  config.track_width_m = 0.4;
  TrackOdometry still(config);
  for (int i = 0; i <= 50; ++i) {
    REQUIRE(still.observe(attitude_at(i * 20 * kMs, {}, {0, 0, 0.001})) == Status::ok);
    REQUIRE(still.update({i * 20 * kMs, 1, 1, 0}) == Status::ok);
  }
  CHECK((still.estimate().flags & estimators::kPoseStationary) != 0);
  CHECK(variance(still, 0) == 0.0);

  TrackOdometry slipping(config);
  for (int i = 0; i <= 50; ++i) {  // the tracks turn against each other, the robot does not
    REQUIRE(slipping.observe(attitude_at(i * 20 * kMs, {}, {})) == Status::ok);
    REQUIRE(slipping.update({i * 20 * kMs, -0.01 * i, 0.01 * i, 0}) == Status::ok);
  }
  CHECK((slipping.estimate().flags & estimators::kPoseSlip) != 0);
  CHECK((slipping.estimate().flags & estimators::kPoseStationary) == 0);
  CHECK(slipping.counters().slips == 50);
  CHECK(norm(position_of(slipping)) == 0.0);
  CHECK(variance(slipping, 0) > 1e-3);
}

TEST_CASE("Refused samples change nothing but their counters, and without an attitude no motion is made up") {
  const double nan = std::nan("");
  TrackOdometry odometry{TrackOdometryConfig{}};
  CHECK(odometry.update({0, 0, 0, 0}) == Status::ok);
  CHECK(odometry.update({20 * kMs, 0.01, 0.01, 0}) == Status::ok);
  CHECK(odometry.counters().no_attitude == 1);
  CHECK(norm(position_of(odometry)) == 0.0);
  CHECK(odometry.observe(attitude_at(20 * kMs, {nan, 0, 0, 0}, {})) == Status::not_finite);
  CHECK(odometry.observe(attitude_at(20 * kMs, {0, 0, 0, 0}, {})) == Status::out_of_range);
  CHECK(odometry.observe(attitude_at(20 * kMs, {}, {0, nan, 0})) == Status::not_finite);
  CHECK(odometry.counters().attitude_refused == 3);
  REQUIRE(odometry.observe(attitude_at(20 * kMs, {}, {})) == Status::ok);
  REQUIRE(odometry.update({40 * kMs, 0.02, 0.02, 0}) == Status::ok);
  const rt::PoseEstimate before = odometry.estimate();
  CHECK(odometry.update({60 * kMs, nan, 0, 0}) == Status::not_finite);
  CHECK(odometry.update({60 * kMs, 0, 1.0 / 0.0, 0}) == Status::not_finite);
  CHECK(odometry.update({60 * kMs, 1e30, 0, 0}) == Status::out_of_range);
  CHECK(odometry.update({40 * kMs, 0.02, 0.02, 0}) == Status::time_repeated);
  CHECK(odometry.update({30 * kMs, 0.02, 0.02, 0}) == Status::time_backwards);
  CHECK(odometry.update({std::numeric_limits<rt::Nanoseconds>::max(), 0.02, 0.02, 0}) ==
        Status::out_of_range);
  const rt::PoseEstimate& after = odometry.estimate();
  CHECK(after.rejected == 6);
  CHECK(after.p_world_body_m[0] == before.p_world_body_m[0]);
  CHECK(after.covariance[0] == before.covariance[0]);
  CHECK(after.stamp_ns == before.stamp_ns);
  const estimators::TrackOdometryCounters& n = odometry.counters();
  CHECK(n.used + n.not_finite + n.out_of_range + n.time_backwards + n.time_repeated + n.time_jumped +
            n.jumps ==
        9);
}

TEST_CASE("An attitude that stops coming is noticed and makes the heading less certain") {
  TrackOdometry odometry{TrackOdometryConfig{}};
  for (int i = 0; i <= 100; ++i) {
    if (i <= 50) REQUIRE(odometry.observe(attitude_at(i * 20 * kMs, {}, {})) == Status::ok);
    REQUIRE(odometry.update({i * 20 * kMs, 0.01 * i, 0.01 * i, 0}) == Status::ok);
  }
  CHECK((odometry.estimate().flags & estimators::kPoseAttitudeStale) != 0);
  CHECK(odometry.counters().attitude_stale == 43);  // 150 ms are bridged
  CHECK(variance(odometry, 5) > 0.05);
  CHECK(position_of(odometry).x == Approx(1.0));
}

TEST_CASE("A turn that the gyro did not see makes the heading less certain, once for each time") {
  const auto heading_variance = [](std::uint32_t flags, int from, int until, double speed) {
    TrackOdometry odometry{TrackOdometryConfig{}};
    for (int i = 0; i <= 100; ++i) {
      rt::AttitudeEstimate attitude = attitude_at(i * 20 * kMs, {}, {});
      attitude.flags |= i >= from ? flags & ~std::uint32_t{estimators::kAttitudeSaturated} : 0u;
      attitude.flags |= i >= from && i < until ? flags : 0u;
      if (speed == 0) attitude.flags |= estimators::kAttitudeStands;
      REQUIRE(odometry.observe(attitude) == Status::ok);
      REQUIRE(odometry.update({i * 20 * kMs, speed * i, speed * i, 0}) == Status::ok);
    }
    return variance(odometry, 5);
  };
  constexpr std::uint32_t kInvalid = estimators::kAttitudeHeadingInvalid;
  constexpr std::uint32_t kClipped = estimators::kAttitudeSaturated;
  const double step = estimators::PoseCovarianceConfig{}.unknown_heading_rad2_per_s * 0.02;
  for (const double speed : {0.01, 0.0}) {
    const double seen = heading_variance(0, 50, 60, speed);
    CHECK(seen < 1e-6);
    CHECK(heading_variance(kClipped, 50, 60, speed) == seen);  // of the accelerometer alone
    CHECK(heading_variance(kInvalid, 50, 60, speed) == Approx(seen + step));
    CHECK(heading_variance(kInvalid | kClipped, 50, 60, speed) == Approx(seen + 10 * step));
  }
}

TEST_CASE("A velocity that nobody knows is told as such") {
  TrackOdometry odometry{TrackOdometryConfig{}};
  CHECK_FALSE(odometry.velocity_known());
  int i = 0;
  for (; i < 10; ++i) {
    REQUIRE(odometry.observe(attitude_at(i * 20 * kMs, {}, {})) == Status::ok);
    REQUIRE(odometry.update({i * 20 * kMs, 0.02 * i, 0.02 * i, 0}) == Status::ok);
    CHECK(odometry.velocity_known());
  }
  CHECK(odometry.estimate().v_body_m_s[0] == Approx(1.0));
  // Another time line: the robot still drives, and the first sample cannot say how fast.
  for (int k = 0; odometry.counters().resumed == 0; ++k) {
    REQUIRE(k < 20);
    const rt::Nanoseconds now = 60'000 * kMs + k * 20 * kMs;
    REQUIRE(odometry.observe(attitude_at(now, {}, {})) == Status::ok);
    static_cast<void>(odometry.update({now, 0.02 * (i + k), 0.02 * (i + k), 0}));
    if (odometry.counters().resumed == 0) continue;
    CHECK_FALSE(odometry.velocity_known());
    const rt::Nanoseconds next = now + 20 * kMs;
    REQUIRE(odometry.observe(attitude_at(next, {}, {})) == Status::ok);
    REQUIRE(odometry.update({next, 0.02 * (i + k + 1), 0.02 * (i + k + 1), 0}) == Status::ok);
    CHECK(odometry.velocity_known());
    CHECK(odometry.estimate().v_body_m_s[0] == Approx(1.0));
  }
  TrackOdometry blind{TrackOdometryConfig{}};
  for (int k = 0; k < 3; ++k) {
    REQUIRE(blind.update({k * 20 * kMs, 0.02 * k, 0.02 * k, 0}) == Status::ok);
    CHECK(blind.velocity_known() == (k == 0));
  }
}

TEST_CASE("Where the attitude is not known a pose says so, and nothing is taken for rest") {
  // The tracks are the first to speak: no attitude at all.
  TrackOdometry odometry{TrackOdometryConfig{}};
  REQUIRE(odometry.update({0, 0, 0, 0}) == Status::ok);
  CHECK(odometry.estimate().flags == (estimators::kPoseStarted | estimators::kPoseAttitudeStale));
  REQUIRE(odometry.update({20 * kMs, 0, 0, 0}) == Status::ok);
  CHECK((odometry.estimate().flags & estimators::kPoseAttitudeStale) != 0);
  CHECK((odometry.estimate().flags & estimators::kPoseStationary) == 0);
  // With one it stands; when that is 150 ms old nobody knows.
  REQUIRE(odometry.observe(attitude_at(40 * kMs, {}, {})) == Status::ok);
  for (int i = 2; i <= 20; ++i) {
    REQUIRE(odometry.update({i * 20 * kMs, 0, 0, 0}) == Status::ok);
    const bool known = i * 20 <= 40 + 150;
    INFO(i);
    CHECK(((odometry.estimate().flags & estimators::kPoseStationary) != 0) == known);
    CHECK(((odometry.estimate().flags & estimators::kPoseAttitudeStale) == 0) == known);
  }
  // Neither is a pose sure that starts on a new time line with an attitude of the old one.
  for (int i = 0; i < 8; ++i) static_cast<void>(odometry.update({60'000 * kMs + i * 20 * kMs, 0, 0, 0}));
  REQUIRE(odometry.counters().resumed == 1);
  CHECK((odometry.estimate().flags & estimators::kPoseAttitudeStale) != 0);
}

TEST_CASE("The history of attitudes interpolates, extrapolates, thins, and survives a clock set back") {
  estimators::AttitudeHistory history(20 * kMs, 100 * kMs);
  const auto yaw = [](rt::Nanoseconds t) { return 0.5 * rt::to_seconds(t); };
  for (rt::Nanoseconds t = 0; t <= 1000 * kMs; t += 3 * kMs) {
    history.add(attitude_at(t, rt::from_yaw_pitch_roll(yaw(t), 0, 0), {0, 0, 0.5}));
  }
  CHECK(history.size() == estimators::AttitudeHistory::kEntries);
  const rt::Nanoseconds newest = history.back(0).stamp_ns;
  CHECK(newest == 999 * kMs);
  const rt::Nanoseconds oldest = history.back(history.size() - 1).stamp_ns;
  CHECK(newest - oldest > 500 * kMs);
  for (rt::Nanoseconds t = oldest; t <= newest + 100 * kMs; t += 7 * kMs) {
    const auto answer = history.at(t);
    REQUIRE(answer.exact);
    REQUIRE(std::fabs(yaw_of(answer.q_world_body) - yaw(t)) < 1e-12);
  }
  CHECK_FALSE(history.at(newest + 101 * kMs).exact);
  CHECK_FALSE(history.at(oldest - 101 * kMs).exact);
  history.add(attitude_at(5, {}, {}));
  CHECK(history.size() == 1);
  CHECK(history.back(0).stamp_ns == 5);
}
