// SPDX-License-Identifier: BSD-3-Clause
// A robot that stands: its heading stands, what it learns makes no mission worse, and no blow leans it.
#include <catch2/catch.hpp>
#include <iostream>

#include "tests/estimators/standing_compare.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::Attitude;
using estimators::AttitudeConfig;

TEST_CASE(
    "A heading at rest turns by 0.05 deg a second at most, and no mission ends worse for what rest taught",
    "[heavy]") {
  for (const double instability : {0.0, 1.0, 10.0}) compare("rests and drives", {0, instability}, 20);
}

TEST_CASE("What rest teaches is paid once the robot moves, and no faster than the setting") {
  AttitudeConfig config;
  Attitude filter{config};
  rt::Nanoseconds now = 0;
  const auto run = [&](double lasts_s, bool moving, double bias) {
    double fastest = 0;
    double before = filter.estimate().delta_heading_rad;
    for (int i = 0; i < static_cast<int>(100 * lasts_s); ++i) {
      now += 10 * kMs;
      filter.set_moving(moving);
      const Vector3 gyr{0, 0, bias + (moving ? 0.2 : 0.0)};
      static_cast<void>(filter.update(sample_of(now, gyr, kGravity, kBoth | rt::kImuMeanRate)));
      const double turned = filter.estimate().delta_heading_rad - before - (moving ? 0.002 : 0.0);
      before = filter.estimate().delta_heading_rad;
      fastest = std::max(fastest, std::fabs(turned));
    }
    return fastest;
  };
  run(20, false, 0.0);
  run(60, true, 0.001);  // a bias that came while it drove: 3.4 deg, of which half is known to be its doing
  const double wrong = filter.estimate().delta_heading_rad - 12.0;
  CHECK(kDegrees * wrong == Approx(3.4).margin(0.1));
  CHECK(kDegrees * run(20, false, 0.001) < 0.004);  // a block's worth
  CHECK(filter.estimate().delta_heading_rad - 12.0 == Approx(wrong).margin(1e-4));
  const double fastest = run(20, true, 0.001);
  CHECK(fastest < 0.04 * config.heading_payment_rad_s + 2e-5);
  const double left = filter.estimate().delta_heading_rad - 16.0;
  CHECK(left < 0.8 * wrong);
  CHECK(left > 0.2 * wrong);  // a drift that grew all the while made half of it
}

TEST_CASE("A turn that looked like standing is not lost: it is owed as soon as the robot moves") {
  Attitude filter{AttitudeConfig{}};
  rt::Nanoseconds now = 0;
  double truth = 0;
  const auto run = [&](double lasts_s, bool moving, double rate) {
    for (int i = 0; i < static_cast<int>(100 * lasts_s); ++i) {
      now += 10 * kMs;
      truth += 0.01 * rate;
      filter.set_moving(moving);
      static_cast<void>(filter.update(sample_of(now, {0, 0, rate}, kGravity, kBoth | rt::kImuMeanRate)));
    }
  };
  run(4, true, 0.2);
  run(1.0, false, 0.02);  // pushed, slower than the limit of rest, for less than rest_time_s
  CHECK(std::fabs(filter.estimate().delta_heading_rad - truth) > 0.005);
  run(6, true, 0.2);
  CHECK(filter.estimate().delta_heading_rad == Approx(truth).margin(2e-3));
}

TEST_CASE("A heading that is set owes nothing of what was turned before") {
  Attitude filter{AttitudeConfig{}};
  rt::Nanoseconds now = 0;
  const auto run = [&](double lasts_s, bool moving, double rate) {
    for (int i = 0; i < static_cast<int>(100 * lasts_s); ++i) {
      now += 10 * kMs;
      filter.set_moving(moving);
      static_cast<void>(filter.update(sample_of(now, {0, 0, rate}, kGravity, kBoth | rt::kImuMeanRate)));
    }
  };
  run(4, true, 0.2);
  run(1.0, false, 0.02);  // withheld: it may have stood
  REQUIRE(filter.set_heading(1.0, 0.01) == Status::ok);
  run(6, true, 0.2);
  CHECK(rt::yaw_of(rt::to_quaternion(filter.estimate().q_world_body)) == Approx(2.2).margin(2e-3));
}

TEST_CASE(
    "A blow in the first second costs 2 deg at most, and nothing a tenth of a second later, from the first "
    "sample on") {
  const Vector3 rest{0.3, -0.2, 9.8};
  const Vector3 directions[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {0.7, 0, 0.7}, {0.7, 0, -0.7}};
  double worst = 0;
  for (const int rate_hz : {100, 500}) {
    for (const double start_s : {0.0, 0.02, 0.1, 0.3, 0.6, 0.95}) {
      for (const double lasts_s : {0.002, 0.01, 0.05}) {
        for (const double size : {3.0, 10.0, 40.0, 160.0}) {
          for (const Vector3& direction : directions) {
            Attitude filter{AttitudeConfig{}};
            double late = 0;
            for (int i = 0; i < 4 * rate_hz; ++i) {
              const double t = static_cast<double>(i) / rate_hz;
              const bool hit = t > start_s - 1e-9 && t < start_s + lasts_s - 1e-9;
              const Vector3 shake{0.05 * std::sin(1.7 * i), 0.05 * std::sin(2.3 * i), 0};
              const Vector3 acc = rest + shake + (hit ? size : 0.0) * direction;
              REQUIRE(filter.update(sample_of((1000 + i * 1000 / rate_hz) * kMs, {0.001, 0.001, 0.001}, acc,
                                              kBoth)) == Status::ok);
              // Who is hit before anything is known, knows it when the next whole block is over.
              if (start_s < 0.1 && t < start_s + lasts_s + 0.1) continue;
              const Vector3 up = rotate_back(attitude_of(filter), {0, 0, 1});
              late = std::max(late, kDegrees * std::atan2(norm(cross(up, rest)), dot(up, rest)));
            }
            INFO(rate_hz << " Hz, " << size << " m/s^2 along " << direction.x << " " << direction.y << " "
                         << direction.z << " at " << start_s << " s for " << lasts_s << " s");
            CHECK(late < 2.0);
            worst = std::max(worst, late);
          }
        }
      }
    }
  }
  std::clog << "a blow in the first second: " << worst << " deg at worst\n";
}
