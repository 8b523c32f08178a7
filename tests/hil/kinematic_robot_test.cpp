// SPDX-License-Identifier: BSD-3-Clause
// The kinematic robot against closed-form arcs, planes, its own derivatives, and walls.
#include "hil/kinematic_robot.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hil/random.hpp"
#include "oracle.hpp"
#include "tests/hil/units.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

rt::DriveCommand command(double left, double right, std::uint32_t flags = 1) {
  rt::DriveCommand c;
  c.left_m_s = left;
  c.right_m_s = right;
  c.flags = flags;
  return c;
}

/// Commands at 50 Hz for a while.
void drive(KinematicRobot& robot, double left, double right, int ms) {
  for (int i = 0; i < ms; ++i) {
    if (i % 20 == 0) REQUIRE(robot.set_command(command(left, right), robot.motion().stamp_ns) == Status::ok);
    robot.step();
  }
}

World& finished(World& world) {
  REQUIRE(world.finalize() == Status::ok);
  return world;
}

double yaw_of(const Quat& q) {
  return std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
}

}  // namespace

TEST_CASE("from rest the robot drives the exact arc") {
  // With a common lag and no limit both belts keep one ratio, so the path is one circle from the first step
  // on.
  World world;
  RobotConfig config;
  config.drives.max_acceleration_m_s2 = 1e9;
  config.drives.max_speed_m_s = 2.0;
  config.turning_centre_x_m = 0.0;
  config.slip_left = 0.03;
  config.slip_right = 0.05;
  config.start_x_m = 1.0;
  config.start_y_m = -2.0;
  config.start_yaw_rad = 0.4;
  KinematicRobot robot(config, finished(world), 0, kMs);
  double worst = 0.0;
  for (int i = 1; i <= 20000; ++i) {
    if (i % 50 == 1) REQUIRE(robot.set_command(command(0.3, 0.5), robot.motion().stamp_ns) == Status::ok);
    robot.step();
    const double t = 0.001 * i;
    const double belt =
        t - config.drives.speed_lag_s * (1.0 - std::exp(-t / config.drives.speed_lag_s));  // per 1 m/s
    const double left = 0.97 * 0.3 * belt;
    const double right = 0.95 * 0.5 * belt;
    const double turn = config.steering_efficiency * (right - left) / config.track_distance_m;
    const double radius = 0.5 * (left + right) / turn;
    const double x = 1.0 + radius * (std::sin(0.4 + turn) - std::sin(0.4));
    const double y = -2.0 - radius * (std::cos(0.4 + turn) - std::cos(0.4));
    const Motion& m = robot.motion();
    worst = std::fmax(worst, std::fabs(m.p_world_body_m.x - x));
    worst = std::fmax(worst, std::fabs(m.p_world_body_m.y - y));
    worst = std::fmax(worst, std::fabs(std::remainder(yaw_of(m.q_world_body) - 0.4 - turn, 2.0 * kPi)));
    REQUIRE(m.left_m == Approx(0.3 * belt).margin(1e-12));
  }
  CHECK(worst < 1e-10);
  CHECK(robot.motion().p_world_body_m.z == 0.0);
}

TEST_CASE("a turning centre behind the middle lets the middle drift sideways on its own circle") {
  World world;
  RobotConfig config;
  config.turning_centre_x_m = -0.1;
  config.slip_left = 0.0;
  config.slip_right = 0.0;
  KinematicRobot robot(config, finished(world), 0, kMs);
  drive(robot, -0.2, 0.2, 10000);
  // Turning on the spot the point at x = -0.1 stays where it was.
  const Motion& m = robot.motion();
  const Vec3 centre = m.p_world_body_m + rotate(m.q_world_body, {-0.1, 0, 0});
  CHECK(centre.x == Approx(-0.1).epsilon(1e-9));
  CHECK(centre.y == Approx(0.0).margin(1e-9));
  CHECK(std::fabs(m.w_body_rad_s.z) == Approx(0.65 * 0.4 / 0.399));
}

TEST_CASE("speed and turn rate are the derivatives of the pose, on ramps and turns alike") {
  World world;
  REQUIRE(world.add(make_wedge({2.0, 0, 0.3, 2.0, 3.0, 0, 0.3})) == Status::ok);
  REQUIRE(world.add(make_box({3.9, 0.6, 0.3, 2.0, 3.0, 0, 0.3}, 100, true)) == Status::ok);
  KinematicRobot robot({}, finished(world), 0, kMs);
  Motion a = robot.motion();
  robot.step();
  Motion b = robot.motion();
  double worst_v = 0.0;
  double worst_w = 0.0;
  double highest = 0.0;
  for (int i = 0; i < 12000; ++i) {
    if (i % 20 == 0) {
      const double bend = 0.1 * std::sin(0.0007 * i);
      REQUIRE(robot.set_command(command(0.4 - bend, 0.4 + bend), robot.motion().stamp_ns) == Status::ok);
    }
    robot.step();
    const Motion& c = robot.motion();
    const Vec3 v = 500.0 * (c.p_world_body_m - a.p_world_body_m);
    worst_v = std::fmax(worst_v, norm(v - b.v_world_m_s));
    const Vec3 w = 500.0 * rotation_vector(conjugate(a.q_world_body) * c.q_world_body);
    worst_w = std::fmax(worst_w, norm(w - b.w_body_rad_s));
    highest = std::fmax(highest, c.p_world_body_m.z);
    a = b;
    b = c;
  }
  CHECK(highest > 0.25);
  CHECK(worst_v < 2e-3);  // central differences over 2 ms at up to 2 m/s^2 and its jumps
  CHECK(worst_w < 5e-3);
  CHECK(robot.counters().obstructed_steps == 0);
}

TEST_CASE("on a slope the robot lies on the plane, whatever its heading") {
  World world;
  const double slope = 0.2;
  REQUIRE(world.add(make_wedge({0, 0, 0.5, 20, 20, 0, 20 * slope})) == Status::ok);
  finished(world);
  const double scale = 1.0 / std::sqrt(1.0 + slope * slope);
  const Vec3 normal{-slope * scale * std::cos(0.5), -slope * scale * std::sin(0.5), scale};
  for (double yaw = -3.0; yaw < 3.2; yaw += 0.4) {
    RobotConfig config;
    config.start_x_m = 0.7;
    config.start_y_m = -0.4;
    config.start_yaw_rad = yaw;
    KinematicRobot robot(config, world, 0, kMs);
    const Motion& m = robot.motion();
    const Vec3 up = rotate(m.q_world_body, {0, 0, 1});
    CHECK(norm(up - normal) < 1e-9);
    const Vec3 nose = rotate(m.q_world_body, {1, 0, 0});
    CHECK(std::atan2(nose.y, nose.x) == Approx(yaw).margin(1e-12));
    CHECK(m.p_world_body_m.z == Approx(2.0 + slope * (0.7 * std::cos(0.5) - 0.4 * std::sin(0.5))));
    drive(robot, 0.3, 0.3, 3000);
    // Straight on: steady attitude, velocity along the nose.
    CHECK(norm(rotate(m.q_world_body, {0, 0, 1}) - normal) < 1e-9);
    CHECK(norm(m.v_world_m_s - 0.3 * 0.98 * rotate(m.q_world_body, {1, 0, 0})) < 1e-5);
  }
}

TEST_CASE("up the ramp and down again ends on the ground, with the travel that the slopes cost") {
  World world;
  REQUIRE(world.add(make_wedge({2.0, 0, 0, 1.5, 2, 0, 0.25})) == Status::ok);
  REQUIRE(world.add(make_box({3.35, 0, 0, 1.2, 2, 0, 0.25}, 100, true)) == Status::ok);
  REQUIRE(world.add(make_wedge({4.7, 0, kPi, 1.5, 2, 0, 0.25})) == Status::ok);
  RobotConfig config;
  config.slip_left = 0.0;
  config.slip_right = 0.0;
  KinematicRobot robot(config, finished(world), 0, kMs);
  drive(robot, 0.4, 0.4, 18000);
  drive(robot, 0.0, 0.0, 1000);
  const Motion& m = robot.motion();
  CHECK(m.p_world_body_m.z == Approx(0.0).margin(1e-9));
  CHECK(m.p_world_body_m.y == Approx(0.0).margin(1e-12));
  const double slope_cost = 2.0 * (std::sqrt(1.5 * 1.5 + 0.25 * 0.25) - 1.5);
  // The body cuts the corners of the profile, so it pays a little less than the slopes' length.
  CHECK(m.left_m - m.p_world_body_m.x < slope_cost);
  CHECK(m.left_m - m.p_world_body_m.x > 0.85 * slope_cost);
  CHECK(robot.counters().obstructed_steps == 0);
}

TEST_CASE("a stale, disabled or missing command stops the robot and a NaN changes nothing") {
  World world;
  KinematicRobot robot({}, finished(world), 0, kMs);
  for (int i = 0; i < 100; ++i) robot.step();
  CHECK(robot.motion().p_world_body_m.x == 0.0);
  CHECK(robot.counters().stale_steps == 0);  // never commanded
  drive(robot, 0.4, 0.4, 1000);
  CHECK(robot.motion().v_world_m_s.x > 0.35);
  const double nan = std::nan("");
  CHECK(robot.set_command(command(nan, 0.1), robot.motion().stamp_ns) == Status::not_finite);
  for (int i = 0; i < 150; ++i) robot.step();
  CHECK(robot.motion().v_world_m_s.x > 0.35);  // 170 ms old: still good
  for (int i = 0; i < 2000; ++i) robot.step();
  CHECK(std::fabs(robot.motion().v_world_m_s.x) < 1e-6);
  CHECK(robot.counters().stale_steps > 1900);
  drive(robot, 0.4, 0.4, 1000);
  REQUIRE(robot.set_command(command(0.4, 0.4, 0), robot.motion().stamp_ns) == Status::ok);
  for (int i = 0; i < 190; ++i) robot.step();
  CHECK(robot.motion().v_world_m_s.x < 0.1);
}

TEST_CASE("commands beyond the drives' speed are limited") {
  World world;
  KinematicRobot robot({}, finished(world), 0, kMs);
  drive(robot, 32.0, 32.0, 3000);
  CHECK(robot.motion().v_world_m_s.x == Approx(0.6 * 0.98));
}

TEST_CASE("a wall holds the body while the belts spin, and lets it go backwards") {
  World world;
  REQUIRE(world.add(make_box({2, 0, 0.3, 0.2, 4, 0, 1})) == Status::ok);
  REQUIRE(world.add(make_cylinder(-2, 0.1, 0.2, 0, 1)) == Status::ok);
  KinematicRobot robot({}, finished(world), 0, kMs);
  Random random(17);
  double closest = 1.0;
  double left = 0.5;
  double right = 0.5;
  for (int i = 0; i < 60000; ++i) {
    if (i % 1500 == 0) {
      const double speed = (i / 9000) % 2 == 0 ? 0.5 : -0.5;
      left = speed + random.uniform(-0.05, 0.05);
      right = speed + random.uniform(-0.05, 0.05);
    }
    if (i % 20 == 0) REQUIRE(robot.set_command(command(left, right), robot.motion().stamp_ns) == Status::ok);
    robot.step();
    // Corners and edges of the outline never enter anything.
    const Motion& m = robot.motion();
    for (int u = -3; u <= 3; ++u) {
      for (int v = -3; v <= 3; ++v) {
        const Vec3 p = m.p_world_body_m + rotate(m.q_world_body, {0.11 * u, 0.25 / 3.0 * v, 0.2});
        closest = std::fmin(closest, oracle::world_depth(world, p));
      }
    }
  }
  CHECK(closest > -1e-9);
  CHECK(closest < 0.01);
  CHECK(robot.counters().obstructed_steps > 5000);
  CHECK(robot.counters().obstructed_steps < 55000);
}

TEST_CASE("a step too high for the tracks holds the robot like a wall") {
  World world;
  REQUIRE(world.add(make_box({2, 0, 0, 1, 4, 0, 0.4}, 100, true)) == Status::ok);
  KinematicRobot robot({}, finished(world), 0, kMs);
  drive(robot, 0.5, 0.5, 8000);
  CHECK(robot.motion().p_world_body_m.x < 1.5);
  CHECK(robot.motion().p_world_body_m.z < 0.2);
  CHECK(robot.counters().obstructed_steps > 1000);
  drive(robot, -0.5, -0.5, 2000);
  CHECK(robot.motion().p_world_body_m.x < 0.8);
  CHECK(robot.motion().p_world_body_m.z == Approx(0.0).margin(1e-6));
}

TEST_CASE("the side of a ramp holds a robot that would fall, also one that drives along the edge") {
  World world;
  REQUIRE(world.add(make_box({0, 0, 0, 6, 1.2, 0, 0.3}, 100, true)) == Status::ok);
  finished(world);
  for (const double yaw : {0.0, 0.3, 1.5707963267948966}) {
    RobotConfig config;
    config.start_yaw_rad = yaw;
    config.turning_centre_x_m = yaw == 0.0 ? -0.5 : 0.0;  // drifts sideways when turning
    KinematicRobot robot(config, world, 0, kMs);
    double roughest = 0.0;
    for (int i = 0; i < 300; ++i) {
      const double bend = yaw == 0.0 ? (i % 20 < 10 ? 0.2 : -0.1) : 0.0;
      drive(robot, 0.4 - bend, 0.4 + bend, 50);
      roughest = std::fmax(roughest, std::fabs(robot.motion().p_world_body_m.z - 0.3));
    }
    CHECK(robot.counters().obstructed_steps > 0);
    CHECK(roughest < 0.1);
  }
}

TEST_CASE("a track that would leave an edge over its whole length at once is held") {
  World world;
  REQUIRE(world.add(make_box({0, 0, 0, 6, 1.2, 0, 0.3}, 100, true)) == Status::ok);
  finished(world);
  RobotConfig config;
  config.turning_centre_x_m =
      -0.5;  // turning left it drifts left, and is parallel to the edge when it gets there
  config.start_yaw_rad = -0.05;
  config.start_y_m = 0.6 - 0.5 * config.track_distance_m - 0.5 * std::sin(0.05);
  KinematicRobot robot(config, world, 0, kMs);
  drive(robot, -0.2, 0.2, 1000);
  CHECK(robot.counters().obstructed_steps > 100);
  CHECK(robot.motion().p_world_body_m.z > 0.29);
  CHECK(std::fabs(rotate(robot.motion().q_world_body, {0, 1, 0}).z) < 0.02);
}

TEST_CASE("a robot that spins for long keeps a small angle and a unit quaternion") {
  World world;
  KinematicRobot robot({}, finished(world), 0, kMs);
  Quat last = robot.motion().q_world_body;
  for (int i = 0; i < 120000; ++i) {
    if (i % 100 == 0) {
      REQUIRE(robot.set_command(command(-0.6, 0.6), robot.motion().stamp_ns) == Status::ok);
    }
    robot.step();
    const Quat& q = robot.motion().q_world_body;
    const double n = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    REQUIRE(n == Approx(1.0).epsilon(1e-14));
    REQUIRE(norm(rotation_vector(conjugate(last) * q)) < 0.003);
    last = q;
  }
}

TEST_CASE("a robot that cannot start says which setting to change") {
  World world;
  REQUIRE(world.add(make_box({0, 0, 0, 1, 1, 0, 1})) == Status::ok);
  finished(world);
  CHECK_THROWS_WITH(KinematicRobot({}, world, 0, kMs), Catch::Contains("start_x_m"));
  RobotConfig config;
  config.start_x_m = 5.0;
  config.steering_efficiency = 0.0;
  CHECK_THROWS_WITH(KinematicRobot(config, world, 0, kMs), Catch::Contains("steering_efficiency"));
  config = {};
  config.drives.speed_lag_s = 0.0;
  CHECK_THROWS_WITH(KinematicRobot(config, world, 0, kMs), Catch::Contains("speed_lag_s"));
  config = {};
  config.slip_left = std::nan("");
  CHECK_THROWS_WITH(KinematicRobot(config, world, 0, kMs), Catch::Contains("slip_left"));
}
