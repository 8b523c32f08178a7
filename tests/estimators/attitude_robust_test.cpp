// SPDX-License-Identifier: BSD-3-Clause
// The attitude filter against samples that no sensor should send: it refuses, bridges, counts, and stays
// finite.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/estimators/attitude_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::Attitude;
using estimators::AttitudeConfig;

TEST_CASE("Free fall and a dead accelerometer leave the attitude to the gyro") {
  Attitude filter{AttitudeConfig{}};
  (void)filter.update(sample_of(0, {}, kGravity, kBoth));
  for (rt::Nanoseconds now = 5 * kMs; now <= 30 * rt::kNanosecondsPerSecond; now += 5 * kMs) {
    REQUIRE(filter.update(sample_of(now, {1e-6, 0, 0}, {0, 0, 0}, kBoth)) == Status::ok);
  }
  CHECK(inclination_error(attitude_of(filter), {}) < 0.01);
  CHECK(is_finite(attitude_of(filter)));
}

TEST_CASE("A gap is bridged with a held rate for half a second at most, and counted") {
  Attitude filter{AttitudeConfig{}};
  const Vector3 rate{0, 0, 1};
  (void)filter.update(sample_of(0, rate, {}, rt::kImuGyr));
  CHECK(filter.update(sample_of(400 * kMs, rate, {}, rt::kImuGyr)) == Status::ok);
  CHECK(filter.estimate().delta_heading_rad == Approx(0.4));
  CHECK(filter.update(sample_of(2400 * kMs, rate, {}, rt::kImuGyr)) == Status::ok);
  CHECK(filter.estimate().delta_heading_rad == Approx(0.9));
  CHECK(filter.counters().gaps == 1);
  CHECK((filter.estimate().flags & estimators::kAttitudeCoasted) != 0);
  CHECK((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) != 0);
  REQUIRE(filter.set_heading(0.3, 0.01) == Status::ok);
  CHECK((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) == 0);
  CHECK(filter.update(sample_of(2500 * kMs, rate, {}, rt::kImuGyr)) == Status::ok);
  CHECK((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) == 0);
}

TEST_CASE("Six exact zeros are no sample: no living sensor reads them") {
  Attitude filter{AttitudeConfig{}};
  CHECK(filter.update(sample_of(0, {}, {}, kBoth)) == Status::out_of_range);
  (void)filter.update(sample_of(5 * kMs, {}, kGravity, kBoth));
  CHECK(filter.update(sample_of(10 * kMs, {}, {}, kBoth)) == Status::out_of_range);
  CHECK(filter.counters().out_of_range == 2);
  CHECK(filter.counters().used == 1);
}

TEST_CASE("A clipped sample is used, counted, and marks the heading") {
  Attitude filter{AttitudeConfig{}};
  (void)filter.update(sample_of(0, {}, kGravity, kBoth));
  CHECK((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) == 0);
  CHECK(filter.update(sample_of(5 * kMs, {0, 0, 35}, kGravity, kBoth | rt::kImuSaturated)) == Status::ok);
  CHECK((filter.estimate().flags & estimators::kAttitudeSaturated) != 0);
  CHECK(filter.update(sample_of(10 * kMs, {0, 0, 1e-3}, kGravity, kBoth)) == Status::ok);
  CHECK((filter.estimate().flags & estimators::kAttitudeSaturated) == 0);
  CHECK((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) != 0);
  CHECK(filter.counters().saturated == 1);
}

TEST_CASE("A blow that clips the accelerometer alone hides no turn") {
  for (const bool told : {false, true}) {
    Attitude filter{AttitudeConfig{}};
    const std::uint32_t clipped = kBoth | rt::kImuSaturated | (told ? +rt::kImuOnlyAccSaturated : 0u);
    double worst = 0.0;
    for (int i = 0; i <= 4000; ++i) {
      const bool blow = i > 2000 && i <= 2004;  // 20 ms, forward and down
      const Vector3 force = blow ? Vector3{160, 0, 160} : kGravity;
      REQUIRE(filter.update(sample_of(i * 5 * kMs, {}, force, blow ? clipped : kBoth)) == Status::ok);
      worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), {}));
    }
    CHECK(filter.counters().saturated == 4);
    CHECK(((filter.estimate().flags & estimators::kAttitudeHeadingInvalid) == 0) == told);
    INFO("worst " << worst << " deg");
    CHECK((worst < 1.0) == told);  // else the inclination is averaged afresh, from the blow on
  }
}

TEST_CASE("A refused sample changes nothing but its counter") {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  Attitude filter{AttitudeConfig{}};
  for (int i = 0; i <= 100; ++i)
    (void)filter.update(sample_of(i * 5 * kMs, {0.1, 0.2, 0.3}, kGravity, kBoth));
  const rt::AttitudeEstimate before = filter.estimate();
  const rt::Nanoseconds next = 505 * kMs;
  struct Case {
    rt::ImuSample sample;
    Status status;
  };
  const Case cases[] = {
      {sample_of(next, {nan, 0, 0}, kGravity, kBoth), Status::not_finite},
      {sample_of(next, {0, -inf, 0}, kGravity, kBoth), Status::not_finite},
      {sample_of(next, {}, {0, 0, nan}, kBoth), Status::not_finite},
      {sample_of(next, {1e30, 0, 0}, kGravity, kBoth), Status::out_of_range},
      {sample_of(next, {}, {0, 1e30, 0}, kBoth), Status::out_of_range},
      {sample_of(next, {}, {}, kBoth), Status::out_of_range},
      {sample_of(next, {}, kGravity, rt::kImuAcc), Status::out_of_range},
      {sample_of(500 * kMs, {}, kGravity, kBoth), Status::time_repeated},
      {sample_of(400 * kMs, {}, kGravity, kBoth), Status::time_backwards},
      {sample_of(std::numeric_limits<rt::Nanoseconds>::max(), {}, kGravity, kBoth), Status::out_of_range},
      {sample_of(std::numeric_limits<rt::Nanoseconds>::min(), {}, kGravity, kBoth), Status::out_of_range},
      {sample_of(next + 3600 * rt::kNanosecondsPerSecond, {}, kGravity, kBoth), Status::out_of_range},
  };
  std::uint32_t refused = 0;
  for (const Case& c : cases) {
    CHECK(filter.update(c.sample) == c.status);
    ++refused;
    const rt::AttitudeEstimate& after = filter.estimate();
    CHECK(after.rejected == refused);
    for (int i = 0; i < 4; ++i) CHECK(after.q_world_body[i] == before.q_world_body[i]);
    CHECK(after.stamp_ns == before.stamp_ns);
    CHECK(after.delta_heading_rad == before.delta_heading_rad);
  }
  const estimators::AttitudeCounters& n = filter.counters();
  CHECK(n.used == 101);
  CHECK(n.used + n.not_finite + n.out_of_range + n.zero_rate + n.time_backwards + n.time_repeated +
            n.time_jumped ==
        101 + refused);
  // NaN accelerometer values do not matter where the flag says that there is none.
  CHECK(filter.update(sample_of(next, {}, {nan, nan, nan}, rt::kImuGyr)) == Status::ok);
}

TEST_CASE("A sensor whose clock was set back is taken up again, without a jump of the attitude") {
  Attitude filter{AttitudeConfig{}};
  for (int i = 0; i <= 100; ++i) (void)filter.update(sample_of(i * 5 * kMs, {0, 0, 0.3}, kGravity, kBoth));
  const Quaternion before = attitude_of(filter);
  int refused = 0;
  for (int i = 0; i < 20; ++i)
    refused += filter.update(sample_of(i * 5 * kMs - 1, {0, 0, 0.3}, kGravity, kBoth)) != Status::ok;
  CHECK(refused == 7);
  CHECK(filter.counters().resumed == 1);
  CHECK(angle_between(before, attitude_of(filter)) < 0.3 * 0.005 * 13 + 1e-9);
}

TEST_CASE("Random rubbish of every kind never makes the state other than finite and of length one") {
  std::mt19937_64 random(99);
  Attitude filter{AttitudeConfig{}};
  const double special[] = {0,      -0.0,         1,         -1,  9.81, 100, 1e-300, 1e30,
                            -1e308, std::nan(""), 1.0 / 0.0, 799, 99};
  const auto value = [&] { return special[random() % 13]; };
  rt::Nanoseconds now = 0;
  std::uint64_t given = 0;
  for (int i = 0; i < 200000; ++i) {
    now += static_cast<rt::Nanoseconds>(random() % 30) * kMs - 2 * kMs;
    const double x = value();
    const double y = value();
    const double z = value();
    const double a = value();
    const double b = value();
    const double c = value();
    const rt::Nanoseconds stamp = random() % 50 == 0 ? static_cast<rt::Nanoseconds>(random()) : now;
    (void)filter.update(sample_of(stamp, {x, y, z}, {a, b, c}, static_cast<std::uint32_t>(random() % 16)));
    ++given;
    REQUIRE(is_finite(attitude_of(filter)));
    REQUIRE(std::fabs(squared_norm(attitude_of(filter)) - 1) < 1e-12);
    REQUIRE(is_finite(rt::to_vector(filter.estimate().bias_rad_s)));
    REQUIRE(std::isfinite(filter.estimate().delta_heading_rad));
  }
  const estimators::AttitudeCounters& n = filter.counters();
  CHECK(n.used > 1000);
  CHECK(n.used + n.not_finite + n.out_of_range + n.zero_rate + n.time_backwards + n.time_repeated +
            n.time_jumped ==
        given);
}
