// SPDX-License-Identifier: BSD-3-Clause
// The simulated IMU: its perfect readings integrate back to the truth, its errors have the statistics asked
// for.
#include "hil/imu_model.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "hil/kinematic_robot.hpp"
#include "tests/hil/units.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

constexpr double kGravity = 9.81;

ImuConfig perfect() {
  ImuConfig config;
  config.gyr_noise_rad_s_rt_hz = config.acc_noise_m_s2_rt_hz = 0.0;
  config.gyr_bias_rad_s = config.acc_bias_m_s2 = 0.0;
  config.gyr_walk_rad_s_rt_s = config.acc_walk_m_s2_rt_s = 0.0;
  return config;
}

/// Strapdown integration as a textbook has it, apart from the plant's: libm, mid-interval rotation of the
/// force.
struct Strapdown {
  Quat q;
  Vec3 v;
  Vec3 p;
  void add(const rt::ImuSample& s, double dt) {
    const Vec3 turn{dt * s.gyr_rad_s[0], dt * s.gyr_rad_s[1], dt * s.gyr_rad_s[2]};
    const auto turned = [&](double share) {
      const double angle = share * norm(turn);
      if (angle < 1e-12) return q;
      const double k = std::sin(0.5 * angle) / norm(turn);
      return normalized(q * Quat{std::cos(0.5 * angle), k * turn.x, k * turn.y, k * turn.z});
    };
    const Vec3 force = rotate(turned(0.5), {s.acc_m_s2[0], s.acc_m_s2[1], s.acc_m_s2[2]});
    const Vec3 a = force - Vec3{0, 0, kGravity};
    p = p + dt * v + (0.5 * dt * dt) * a;
    v = v + dt * a;
    q = turned(1.0);
  }
};

}  // namespace

TEST_CASE("perfect readings integrate back to the true pose over ramps and turns") {
  World world;
  REQUIRE(world.add(make_wedge({2.0, 0, 0.1, 2.0, 8.0, 0, 0.3})) == Status::ok);
  REQUIRE(world.add(make_box({3.99, 0.2, 0.1, 2.002, 8.0, 0, 0.3}, 100, true)) == Status::ok);
  REQUIRE(world.add(make_wedge({5.98, 0.4, 0.1 + 3.14159265358979, 2.0, 8.0, 0, 0.3})) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  KinematicRobot robot({}, world, 0, kMs);
  InertialIntegral inertia({});
  ImuModel imu(perfect(), 1);
  Strapdown strapdown;
  double worst_heading = 0.0;
  double worst_tilt = 0.0;
  double worst_velocity = 0.0;
  double worst_position = 0.0;
  double highest = 0.0;
  for (int i = 1; i <= 30000; ++i) {
    if (i % 20 == 1) {
      rt::DriveCommand c;
      const double bend = i < 16000 ? 0.03 * std::sin(0.002 * i) : 0.25;
      c.left_m_s = 0.4 - bend;
      c.right_m_s = 0.4 + bend;
      c.flags = 1;
      REQUIRE(robot.set_command(c, robot.motion().stamp_ns) == Status::ok);
    }
    const Motion before = robot.motion();
    robot.step();
    inertia.add(before, robot.motion());
    if (i % 5 != 0) continue;
    rt::ImuSample sample;
    REQUIRE(imu.read(inertia.take(), robot.motion().stamp_ns, sample));
    strapdown.add(sample, 0.005);
    const Motion& m = robot.motion();
    highest = std::fmax(highest, m.p_world_body_m.z);
    const Vec3 nose = rotate(strapdown.q, {1, 0, 0});
    const Vec3 true_nose = rotate(m.q_world_body, {1, 0, 0});
    const double heading = std::atan2(nose.y, nose.x) - std::atan2(true_nose.y, true_nose.x);
    worst_heading = std::fmax(worst_heading, std::fabs(std::sin(heading)));
    worst_tilt =
        std::fmax(worst_tilt, norm(rotate(strapdown.q, {0, 0, 1}) - rotate(m.q_world_body, {0, 0, 1})));
    worst_velocity = std::fmax(worst_velocity, norm(strapdown.v - m.v_world_m_s));
    worst_position = std::fmax(worst_position, norm(strapdown.p - m.p_world_body_m));
  }
  CHECK(highest > 0.28);
  CHECK(robot.counters().obstructed_steps == 0);
  INFO("velocity " << worst_velocity << " position " << worst_position << " heading " << worst_heading);
  CHECK(worst_heading < 1e-6);
  CHECK(worst_tilt < 1e-6);
  CHECK(worst_velocity < 1e-4);
  CHECK(worst_position < 2e-3);
}

TEST_CASE("at rest the specific force is gravity upwards, turned into the body") {
  World world;
  REQUIRE(world.add(make_wedge({0, 0, 0, 20, 20, 0, 4})) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  for (const double yaw : {0.0, 1.0, -2.0}) {
    RobotConfig config;
    config.start_yaw_rad = yaw;
    KinematicRobot robot(config, world, 0, kMs);
    InertialIntegral inertia({0.1, 0.2, 0.3});
    for (int i = 0; i < 5; ++i) {
      const Motion before = robot.motion();
      robot.step();
      inertia.add(before, robot.motion());
    }
    const InertialTruth truth = inertia.take();
    const Vec3 expected = kGravity * rotate(conjugate(robot.motion().q_world_body), {0, 0, 1});
    CHECK(norm(truth.acc_m_s2 - expected) < 1e-9);
    CHECK(norm(truth.gyr_rad_s) < 1e-9);
    // The slope of 0.2 seen from a body with this heading.
    CHECK(truth.acc_m_s2.x ==
          Approx(kGravity * rotate(robot.motion().q_world_body, {1, 0, 0}).z).margin(1e-9));
    CHECK(truth.acc_m_s2.z == Approx(kGravity / std::sqrt(1.04)).margin(1e-9));
  }
}

TEST_CASE("a sensor off the centre of a steady turn feels the acceleration of its own circle") {
  World world;
  REQUIRE(world.finalize() == Status::ok);
  RobotConfig config;
  config.turning_centre_x_m = 0.0;
  KinematicRobot robot(config, world, 0, kMs);
  for (const Vec3& arm : {Vec3{0.3, 0, 0}, Vec3{-0.2, 0.1, 0.4}}) {
    InertialIntegral inertia(arm);
    for (int i = 0; i < 3000; ++i) {
      if (i % 20 == 0) {
        rt::DriveCommand c;
        c.left_m_s = 0.2;
        c.right_m_s = 0.5;
        c.flags = 1;
        REQUIRE(robot.set_command(c, robot.motion().stamp_ns) == Status::ok);
      }
      const Motion before = robot.motion();
      robot.step();
      if (i >= 2995) inertia.add(before, robot.motion());
    }
    const InertialTruth truth = inertia.take();
    const double w = 0.65 * 0.98 * 0.3 / 0.399;
    const double v = 0.98 * 0.35;
    CHECK(truth.gyr_rad_s.z == Approx(w).epsilon(1e-9));
    CHECK(truth.acc_m_s2.x == Approx(-w * w * arm.x).margin(1e-6));
    CHECK(truth.acc_m_s2.y == Approx(w * v - w * w * arm.y).margin(1e-6));
    CHECK(truth.acc_m_s2.z == Approx(kGravity));
  }
}

TEST_CASE("white noise has the density asked for, on each axis by itself") {
  ImuConfig config = perfect();
  config.gyr_noise_rad_s_rt_hz = 1e-3;
  config.acc_noise_m_s2_rt_hz = 2e-3;
  ImuModel imu(config, 5);
  constexpr int kSamples = 40000;
  double sum[6]{};
  double sum2[6]{};
  double neighbours[6]{};
  double cross_axes = 0.0;
  double last[6]{};
  for (int i = 0; i < kSamples; ++i) {
    rt::ImuSample s;
    REQUIRE(imu.read({{0.1, 0.2, 0.3}, {0, 0, kGravity}}, i, s));
    const double e[6] = {s.gyr_rad_s[0] - 0.1, s.gyr_rad_s[1] - 0.2, s.gyr_rad_s[2] - 0.3,
                         s.acc_m_s2[0],        s.acc_m_s2[1],        s.acc_m_s2[2] - kGravity};
    for (int k = 0; k < 6; ++k) {
      sum[k] += e[k];
      sum2[k] += e[k] * e[k];
      neighbours[k] += e[k] * last[k];
      last[k] = e[k];
    }
    cross_axes += e[0] * e[1];
  }
  for (int k = 0; k < 6; ++k) {
    INFO("axis " << k << ", seed 5");
    const double sigma = (k < 3 ? 1e-3 : 2e-3) * std::sqrt(200.0);
    const double root = std::sqrt(static_cast<double>(kSamples));
    CHECK(std::fabs(sum[k] / kSamples) < 4.0 * sigma / root);
    CHECK(sum2[k] / kSamples == Approx(sigma * sigma).epsilon(4.0 * std::sqrt(2.0) / root));
    CHECK(std::fabs(neighbours[k] / kSamples) < 4.0 * sigma * sigma / root);
  }
  CHECK(std::fabs(cross_axes / kSamples) < 4.0 * 1e-6 * 200.0 / std::sqrt(static_cast<double>(kSamples)));
}

TEST_CASE("biases start with the spread asked for and wander with the square root of time") {
  ImuConfig config = perfect();
  config.gyr_bias_rad_s = 0.01;
  config.acc_walk_m_s2_rt_s = 0.002;
  constexpr int kDevices = 2000;
  double start2 = 0.0;
  double walk2 = 0.0;
  for (std::uint64_t seed = 0; seed < kDevices; ++seed) {
    ImuModel imu(config, seed);
    start2 += dot(imu.gyr_bias_rad_s(), imu.gyr_bias_rad_s()) / 3.0;
    CHECK(norm(imu.acc_bias_m_s2()) == 0.0);
    rt::ImuSample s;
    for (int i = 0; i < 100; ++i) static_cast<void>(imu.read({}, i, s));  // half a second
    walk2 += dot(imu.acc_bias_m_s2(), imu.acc_bias_m_s2()) / 3.0;
  }
  const double spread = 4.0 * std::sqrt(2.0 / (3.0 * kDevices));
  CHECK(start2 / kDevices == Approx(1e-4).epsilon(spread));
  CHECK(walk2 / kDevices == Approx(0.002 * 0.002 * 0.5).epsilon(spread));
}

TEST_CASE("a clipped axis is marked, and the share of lost samples is the one asked for") {
  ImuConfig config = perfect();
  config.gyr_range_rad_s = 5.0;
  config.loss = 0.1;
  ImuModel imu(config, 9);
  int given = 0;
  for (int i = 0; i < 20000; ++i) {
    rt::ImuSample s;
    const bool fast = i % 10 == 0;
    if (!imu.read({{0, fast ? -7.0 : 4.9, 0}, {0, 0, kGravity}}, i, s)) continue;
    ++given;
    REQUIRE(s.gyr_rad_s[1] == (fast ? -5.0 : 4.9));
    REQUIRE(((s.flags & rt::kImuSaturated) != 0) == fast);
    REQUIRE((s.flags & rt::kImuOnlyAccSaturated) == 0);
    REQUIRE((s.flags & rt::kImuMeanRate) != 0);
    REQUIRE(s.stamp_ns == i);
  }
  CHECK(imu.clipped() == 2000);
  CHECK(imu.lost() == static_cast<std::uint64_t>(20000 - given));
  CHECK(given == Approx(18000).margin(4.0 * std::sqrt(20000 * 0.09)));
}

TEST_CASE("an IMU that cannot be says which setting to change") {
  ImuConfig config;
  config.rate_hz = 300;
  CHECK_THROWS_WITH(ImuModel(config, 1), Catch::Contains("rate_hz"));
  config = {};
  config.gyr_noise_rad_s_rt_hz = -1.0;
  CHECK_THROWS_WITH(ImuModel(config, 1), Catch::Contains("noise"));
  config = {};
  config.loss = 1.5;
  CHECK_THROWS_WITH(ImuModel(config, 1), Catch::Contains("loss"));
}
