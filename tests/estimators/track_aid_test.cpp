// SPDX-License-Identifier: BSD-3-Clause
// The attitude with the tracks' speed: accelerations that last, turns, the sensor off the centre, and slip.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "tests/estimators/attitude_samples.hpp"

using namespace sortie;
using namespace sortie::estimators::test;
using estimators::Attitude;
using estimators::AttitudeConfig;

namespace {
constexpr std::uint32_t kMeans = kBoth | rt::kImuMeanRate;

double noise(std::mt19937& random) {
  double sum = 0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() % 65536u) / 65536.0;
  return sum - 6;
}
Vector3 noise3(std::mt19937& random, double sigma) {
  const double x = noise(random);
  const double y = noise(random);
  const double z = noise(random);
  return sigma * Vector3{x, y, z};
}

struct Worst {
  double inclination_deg;
  std::uint64_t refused;
};

/// Pushes of `push` m/s^2 for ten seconds forward and ten back, at 100 Hz, speed known at 10 or 100 Hz.
Worst drive(double push, bool aided, int speed_every) {
  std::mt19937 random(3);
  Attitude filter{AttitudeConfig{}};
  filter.set_moving(true);
  double speed = 0;
  double worst = 0;
  for (int i = 0; i < 6000; ++i) {
    const double a = i >= 2000 && i < 3000 ? push : (i >= 3000 && i < 4000 ? -push : 0.0);
    speed += 0.01 * a;
    if (aided && i % speed_every == 0)
      REQUIRE(filter.set_track_speed(speed + 0.01 * noise(random), i * 10 * kMs) == Status::ok);
    const Vector3 gyr = noise3(random, 0.001);
    const Vector3 acc = Vector3{a, 0, 9.81} + noise3(random, 0.05);
    REQUIRE(filter.update(sample_of(i * 10 * kMs, gyr, acc, kMeans)) == Status::ok);
    worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), {}));
  }
  return {worst, filter.counters().aid_refused};
}
}  // namespace

TEST_CASE("Ten seconds of 3 m/s^2 tilt it by less than 1.5 deg with the tracks' speed, by 15 without") {
  CHECK(drive(3, false, 1).inclination_deg > 15);
  for (const int every : {1, 10}) {
    const Worst aided = drive(3, true, every);
    INFO("speed at every " << every << "th sample: " << aided.inclination_deg << " deg");
    CHECK(aided.inclination_deg < 1.5);
    CHECK(aided.refused == 0);
  }
  CHECK(drive(-3, true, 1).inclination_deg < 1.5);
}

TEST_CASE("A circle and a sensor off the centre cost nothing when both are known") {
  constexpr double kSpeed = 1.5;
  constexpr double kTurn = 1.2;
  const Vector3 arm{0.3, -0.2, 0.1};
  double found[2]{};
  for (const bool aided : {false, true}) {
    AttitudeConfig config;
    rt::store(arm, config.p_body_imu_m);
    Attitude filter{config};
    filter.set_moving(true);
    double worst = 0;
    for (int i = 0; i < 12'000; ++i) {
      const double t = 0.005 * i - 5;  // five seconds at rest first
      const bool starting = t > 0 && t < 5;
      const double ramp = std::clamp(t / 5, 0.0, 1.0);
      const double w = kTurn * ramp;
      const double dw = starting ? kTurn / 5 : 0.0;
      const double v = kSpeed * ramp;
      const double dv = starting ? kSpeed / 5 : 0.0;
      // w x v + dw x arm + w x (w x arm), about z
      const Vector3 a{dv - dw * arm.y - w * w * arm.x, w * v + dw * arm.x - w * w * arm.y, 0};
      if (aided) REQUIRE(filter.set_track_speed(v, i * 5 * kMs) == Status::ok);
      REQUIRE(filter.update(sample_of(i * 5 * kMs, {0, 1e-6, w}, a + kGravity, kBoth)) == Status::ok);
      worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), {}));
    }
    found[aided ? 1 : 0] = worst;
  }
  INFO("plain " << found[0] << " deg, aided " << found[1] << " deg");
  CHECK(found[1] < 0.15);
  CHECK(found[1] < found[0] / 3);
}

TEST_CASE("Tracks that spin on the spot lose trust, and get it back when they hold again") {
  std::mt19937 random(5);
  Attitude filter{AttitudeConfig{}};
  filter.set_moving(true);
  double speed = 0;
  double worst = 0;
  bool refused = false;
  for (int i = 0; i < 12'000; ++i) {
    const double t = 0.005 * i;
    const bool slip = t > 10 && t < 16;
    const bool push = t > 30 && t < 40;
    if (slip) speed += 0.005 * 2;  // the belts run away while the robot stands
    if (t >= 16 && t < 20) speed = 0;
    if (push) speed += 0.005 * 2;
    REQUIRE(filter.set_track_speed(speed, i * 5 * kMs) == Status::ok);
    const Vector3 gyr = noise3(random, 0.002);
    const Vector3 acc = Vector3{push ? 2.0 : 0.0, 0, 9.81} + noise3(random, 0.1);
    REQUIRE(filter.update(sample_of(i * 5 * kMs, gyr, acc, kMeans)) == Status::ok);
    worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), {}));
    refused = refused || (filter.estimate().flags & estimators::kAttitudeAidRefused) != 0;
    if (push && t > 31) REQUIRE((filter.estimate().flags & estimators::kAttitudeAided) != 0);
  }
  INFO("worst " << worst << " deg");
  CHECK(refused);
  CHECK(filter.counters().aid_refused >= 1);
  CHECK(worst < 2.0);
}

TEST_CASE("A wild velocity leaves nothing behind, whether it loses the trust or not") {
  for (const double wild : {0.6, 1.5, -2.8, 20.0}) {
    for (int length = 1; length <= 16; ++length) {
      std::mt19937 random(7);
      Attitude filter{AttitudeConfig{}};
      filter.set_moving(true);
      double after = 0;
      for (int i = 0; i < 4000; ++i) {
        const double speed = i >= 3000 && i < 3000 + length ? wild : 0.3;
        REQUIRE(filter.set_track_velocity({speed, 0, 0}, i * 5 * kMs) == Status::ok);
        const Vector3 gyr = noise3(random, 0.002);
        const Vector3 acc = kGravity + noise3(random, 0.1);
        REQUIRE(filter.update(sample_of(i * 5 * kMs, gyr, acc, kMeans)) == Status::ok);
        if (i >= 3100) after = std::max(after, kDegrees * inclination_error(attitude_of(filter), {}));
      }
      INFO("speed " << wild << " m/s for " << 5 * length << " ms: " << after << " deg");
      CHECK(after < 0.6);  // trust comes back at 0.2 m/s^2 over a second; cut-off 0.47 rad/s, over g
    }
  }
}

TEST_CASE("A body that tips over an edge is aided by all of its velocity, not by the part along its axis") {
  double found[2]{};
  for (const bool whole : {false, true}) {
    Attitude filter{AttitudeConfig{}};
    filter.set_moving(true);
    double worst = 0;
    double nose_up = 0.0;
    for (int i = 0; i < 4000; ++i) {
      // Steady along the world's x; for a second the nose goes up by 0.6 rad, and down again a second later.
      const double t = 0.005 * i;
      const double w = t > 12 && t <= 13 ? 0.6 : t > 15 && t <= 16 ? -0.6 : 0.0;
      nose_up += 0.005 * w;
      const Quaternion q = rt::from_yaw_pitch_roll(0, -nose_up, 0);
      const bool starts = t > 2 && t <= 7;
      const Vector3 v_body = rotate_back(q, {std::clamp(0.2 * (t - 2), 0.0, 1.0), 0, 0});
      const Vector3 a_world{starts ? 0.2 : 0.0, 0, 0};
      const Vector3 force = rotate_back(q, a_world + kGravity);
      const Vector3 told = whole ? v_body : Vector3{v_body.x, 0, 0};
      REQUIRE(filter.set_track_velocity(told, i * 5 * kMs) == Status::ok);
      REQUIRE(filter.update(sample_of(i * 5 * kMs, {1e-6, -w, 0}, force, kMeans)) == Status::ok);
      if (t > 11) worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), q));
    }
    found[whole ? 1 : 0] = worst;
  }
  INFO("by x " << found[0] << " deg, by all " << found[1] << " deg");
  CHECK(found[1] < 0.1);
  CHECK(found[0] > 0.3);
}

TEST_CASE(
    "Blows that end a fall count in full where the velocity tells of them, and are shortened where not") {
  double found[3]{};
  for (const int told : {0, 1, 2}) {  // nothing, the velocity, a velocity without the falls
    Attitude filter{AttitudeConfig{}};
    filter.set_moving(true);
    double worst = 0;
    double fall_m_s = 0;
    for (int i = 0; i < 6000; ++i) {
      // Down an edge, every second for 100 ms with 5 m/s^2, and ahead with a third of it; stopped in 5 ms.
      const int phase = i % 200;
      const double before_m_s = fall_m_s;
      fall_m_s = i < 1000 || phase >= 20 ? 0.0 : fall_m_s + 0.005 * 5;
      const Vector3 along{1.0 / 3, 0, -1};
      const Vector3 force = kGravity + ((fall_m_s - before_m_s) / 0.005) * along;
      REQUIRE(filter.update(sample_of(i * 5 * kMs, {1e-6, 0, 0}, force, kMeans)) == Status::ok);
      const Vector3 v = Vector3{0.3, 0, 0} + (told == 1 ? fall_m_s : 0.0) * along;
      // As the tracks do: 10 ms apart, known after the samples of that time.
      if (told > 0 && i % 2 == 0) REQUIRE(filter.set_track_velocity(v, i * 5 * kMs) == Status::ok);
      if (i > 1000) worst = std::max(worst, kDegrees * inclination_error(attitude_of(filter), {}));
    }
    CHECK(filter.counters().shortened >= 20);
    found[told] = worst;
  }
  INFO("without aid " << found[0] << ", with " << found[1] << ", told otherwise " << found[2] << " deg");
  CHECK(found[1] < 0.25 * found[0]);
  CHECK(found[2] < 1.1 * found[0]);
}

TEST_CASE("An aid that is not renewed ends by itself, and a speed that is no number is refused") {
  Attitude filter{AttitudeConfig{}};
  CHECK(filter.set_track_speed(std::nan(""), 0) == Status::not_finite);
  CHECK(filter.set_track_speed(1e30, 0) == Status::out_of_range);
  CHECK(filter.set_track_speed(1, std::numeric_limits<rt::Nanoseconds>::min()) == Status::out_of_range);
  for (int i = 0; i < 800; ++i) {
    if (i < 600) REQUIRE(filter.set_track_speed(1.0, i * 5 * kMs) == Status::ok);
    REQUIRE(filter.update(sample_of(i * 5 * kMs, {0.01, 0, 0}, kGravity, kBoth)) == Status::ok);
    if (i == 599) CHECK((filter.estimate().flags & estimators::kAttitudeAided) != 0);
  }
  CHECK((filter.estimate().flags & estimators::kAttitudeAided) == 0);
}
