// SPDX-License-Identifier: BSD-3-Clause
// Inertial samples that do not carry all they could: no estimator reads what is absent.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "estimators/uav_state/uav_estimator.hpp"
#include "tests/estimators/attitude_samples.hpp"
#include "tests/estimators/odometry_samples.hpp"

namespace {
using namespace sortie;
using namespace sortie::estimators::test;

constexpr double kJunk[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                            1e300, 1e30, 5.0};

rt::ImuSample littered(rt::ImuSample sample, double junk) {
  for (int i = 0; i < 3; ++i) {
    if ((sample.flags & rt::kImuGyr) == 0) sample.gyr_rad_s[i] = junk;
    if ((sample.flags & rt::kImuAcc) == 0) sample.acc_m_s2[i] = junk;
  }
  return sample;
}

// All state, byte by byte.
template <class Estimator>
std::vector<std::uint8_t> bytes_of(Estimator& estimator) {
  rt::Archive measure = rt::Archive::measuring();
  estimator.archive(measure);
  REQUIRE(measure.status() == Status::ok);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
  rt::Archive out = rt::Archive::writing(bytes);
  estimator.archive(out);
  REQUIRE(out.status() == Status::ok);
  return bytes;
}

// A body that nods; each sample carries another part of all there is.
rt::ImuSample nodding(int i) {
  const double t = 0.005 * i;
  rt::ImuSample sample = sample_of(i * 5 * kMs, {0.3 * rt::sin(2 * t), 0.2 * rt::sin(3 * t), 0.1},
                                   {0.5 * rt::sin(t), 0.3, 9.81}, 0);
  constexpr std::uint32_t kParts[] = {kBoth, rt::kImuGyr, kBoth, rt::kImuAcc, kBoth, 0, kBoth};
  sample.flags = i < 200 ? kBoth : kParts[i % 7];
  if (i % 11 == 0) sample.flags |= rt::kImuMeanRate;
  if (i % 13 == 0) sample.flags |= rt::kImuSaturated;
  if (i % 26 == 0) sample.flags |= rt::kImuOnlyAccSaturated;
  return sample;
}
}  // namespace

TEST_CASE("The attitude filter does not read what an inertial sample does not carry") {
  for (const double junk : kJunk) {
    CAPTURE(junk);
    estimators::Attitude plain{estimators::AttitudeConfig{}};
    estimators::Attitude junked{estimators::AttitudeConfig{}};
    for (int i = 1; i <= 1400; ++i) {
      const rt::ImuSample sample = nodding(i);
      const Status expected = plain.update(littered(sample, 0.0));
      REQUIRE(junked.update(littered(sample, junk)) == expected);
      if ((sample.flags & rt::kImuGyr) == 0) REQUIRE(expected == Status::out_of_range);
    }
    CHECK(junked.counters().not_finite == 0);
    CHECK(bytes_of(junked) == bytes_of(plain));
  }
}

TEST_CASE("The flight estimator does not read what an inertial sample does not carry") {
  for (const double junk : kJunk) {
    CAPTURE(junk);
    estimators::UavEstimator plain{estimators::UavEstimatorConfig{}};
    estimators::UavEstimator junked{estimators::UavEstimatorConfig{}};
    for (int i = 1; i <= 600; ++i) {
      rt::ImuSample sample = nodding(i);
      if (i < 200) sample = sample_of(i * 5 * kMs, {}, kGravity, kBoth);
      const Status expected = plain.imu(littered(sample, 0.0), 9.81);
      REQUIRE(junked.imu(littered(sample, junk), 9.81) == expected);
      REQUIRE((expected == Status::ok) == ((sample.flags & kBoth) == kBoth));
      if (expected != Status::ok) REQUIRE(expected == Status::out_of_range);
    }
    CHECK(bytes_of(junked) == bytes_of(plain));
  }
}

TEST_CASE("The odometry on obstacles does not read what an inertial sample does not carry") {
  estimators::TrackOdometryConfig config;
  config.obstacles = true;
  for (const double junk : kJunk) {
    CAPTURE(junk);
    estimators::TrackOdometry plain{config};
    estimators::TrackOdometry junked{config};
    for (int i = 1; i <= 1000; ++i) {
      const rt::ImuSample sample = nodding(i);
      const rt::AttitudeEstimate attitude =
          attitude_at(sample.stamp_ns, rt::from_yaw_pitch_roll(0.001 * i, 0.0, 0.0), {0, 0, 0.2});
      for (estimators::TrackOdometry* each : {&plain, &junked}) {
        REQUIRE(each->observe(attitude) == Status::ok);
        each->feel(littered(sample, each == &plain ? 0.0 : junk));
        if (i % 4 == 0) REQUIRE(each->update({sample.stamp_ns, 0.001 * i, 0.001 * i, 0}) == Status::ok);
      }
    }
    CHECK(bytes_of(junked) == bytes_of(plain));
  }
}
