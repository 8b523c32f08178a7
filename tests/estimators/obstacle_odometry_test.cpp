// SPDX-License-Identifier: BSD-3-Clause
// What the odometry on obstacles makes of what the accelerometer feels.
#include "estimators/obstacle_odometry.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace {
using namespace sortie;
using estimators::ObstacleOdometry;
using estimators::TrackMotion;

constexpr rt::Nanoseconds kSampleNs = 2 * rt::kNanosecondsPerMillisecond;

// A step of 10 ms of a level robot that stands, with five samples of one force along up, of which `others`
// (the first ones) are plain ones.
TrackMotion stand(ObstacleOdometry& odometry, rt::Nanoseconds& now, double force_m_s2, std::uint32_t flags,
                  int others = 0) {
  for (int i = 0; i < 5; ++i) {
    now += kSampleNs;
    rt::ImuSample sample;
    sample.stamp_ns = now;
    sample.acc_m_s2[2] = force_m_s2;
    sample.flags = rt::kImuGyr | (i < others ? +rt::kImuAcc : flags);
    odometry.feel(sample, {});
  }
  return odometry.advance({0.01, 0.0, {}, {}});
}

// What one step of `force` does to a robot that has stood for a second.
TrackMotion felt(double force_m_s2, std::uint32_t flags, double& speed_m_s, int others = 0) {
  ObstacleOdometry odometry{estimators::ObstacleOdometryConfig{}};
  rt::Nanoseconds now = 0;
  for (int i = 0; i < 100; ++i) static_cast<void>(stand(odometry, now, 9.81, rt::kImuAcc));
  const TrackMotion motion = stand(odometry, now, force_m_s2, flags, others);
  speed_m_s = odometry.vertical().speed_m_s();
  return motion;
}
}  // namespace

TEST_CASE("A blow is felt where its size is known, and the height is the belts' where it is not") {
  double speed = 0;
  CHECK(felt(60.0, rt::kImuAcc, speed).travel_world_m.z > 1e-5);
  CHECK(speed > 1e-3);
  for (const std::uint32_t flags : {rt::kImuAcc | rt::kImuSaturated, 0u, +rt::kImuSaturated}) {
    CAPTURE(flags);
    CHECK(felt(60.0, flags, speed).travel_world_m.z == Approx(0.0).margin(1e-12));
    CHECK(std::fabs(speed) < 1e-9);
  }
  // One sample that was clipped is enough; one that was not there is not.
  CHECK(felt(60.0, rt::kImuAcc | rt::kImuSaturated, speed, 4).travel_world_m.z == Approx(0.0).margin(1e-12));
  CHECK(felt(60.0, 0, speed, 4).travel_world_m.z > 1e-5);
  CHECK(felt(1e4, rt::kImuAcc, speed).travel_world_m.z == Approx(0.0).margin(1e-12));  // no sensor feels that
  CHECK(felt(std::nan(""), rt::kImuAcc, speed).travel_world_m.z == Approx(0.0).margin(1e-12));
}
