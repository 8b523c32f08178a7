// SPDX-License-Identifier: BSD-3-Clause
// The attitude filter in float beside itself in double: closed forms, a fast spin, and half an hour.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/estimators/attitude_day.hpp"

using namespace sortie;
using namespace sortie::estimators::test;

TEST_CASE("A spin of 100 rad/s at 100 Hz is followed within 0.2 deg for ten seconds, in float too") {
  for (const std::uint32_t flags : {kBoth, kBoth | rt::kImuMeanRate, std::uint32_t{rt::kImuGyr}}) {
    estimators::Attitude wide{{}};
    estimators::AttitudeFloat narrow{{}};
    const Vector3 rate = 100.0 * Vector3{0.6, -0.48, 0.64};
    Quaternion truth;
    for (int i = 0; i <= 1000; ++i) {
      truth = exp_rotation(0.01 * i * rate);
      const rt::ImuSample sample = sample_of(i * 10 * kMs, rate, rotate_back(truth, kGravity), flags);
      REQUIRE(wide.update(sample) == Status::ok);
      REQUIRE(narrow.update(sample) == Status::ok);
    }
    const Quaternion q = normalised(rt::to_quaternion(narrow.estimate().q_world_body));
    CHECK(kDegrees * angle_between(attitude_of(wide), truth) < 1e-9);
    CHECK(kDegrees * angle_between(q, truth) < 0.01);
  }
}

TEST_CASE("Half an hour in float ends where it ends in double", "[heavy]") {
  for (const bool moving : {false, true}) {
    const DayErrors errors = run_day(0.5, moving);
    INFO("moving " << moving << ": apart " << errors.apart_deg << " deg");
    CHECK(errors.apart_deg < 0.05);  // rest may be seen a block apart
    CHECK(std::fabs(errors.heading_deg[1] - errors.heading_deg[0]) < 1e-3);
    CHECK(errors.length[0] < 1e-14);
    CHECK(errors.length[1] < 5e-7);
    CHECK(errors.inclination_deg[1] < errors.inclination_deg[0] + 0.005);
  }
}
