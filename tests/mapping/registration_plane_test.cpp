// SPDX-License-Identifier: BSD-3-Clause
// Lidars of one row: x, y and yaw are matched, and what the plane leaves out stays what it was told to be.
#include <catch2/catch.hpp>

#include "mapping/registration/pose_algebra.hpp"
#include "rt/digest.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/mapping/registration_rig.hpp"
#include "tests/mapping/twins/decompositions.hpp"

namespace {
using namespace sortie;
using mapping::LocateVerdict;
using mapping::RigidPose;

constexpr rt::Nanoseconds kPlaneTick_ns = 150'000'000;

mapping::RegistrationConfig planar_config() {
  mapping::RegistrationConfig config;
  config.planar = true;
  config.edge_m = 0.05;
  return config;
}

testing::TestLidar one_row(double noise_m = 0.01) {
  testing::TestLidar lidar;
  lidar.rows = 1;
  lidar.noise_m = noise_m;
  return lidar;
}

/// A storey: a hall of walls that go all the way up, rooms beside it, things in them.
testing::RegistrationWorld storey(testing::Draws& draws) {
  testing::RegistrationWorld world;
  const double width = draws.uniform(6, 9), length = draws.uniform(9, 14);
  world.boxes.push_back({{0, 0, 5}, {length, width, 20}, 0});
  for (const double side : {-1.0, 1.0}) {
    for (double x = -length + draws.uniform(2, 3); x < length - 2; x += draws.uniform(3, 4.5)) {
      world.boxes.push_back({{x, side * (0.5 * width + 2), 5}, {0.08, 0.5 * width - 2, 20}, 0});
      world.boxes.push_back(
          {{x + 1.2, side * 0.9 * width, 5}, {draws.uniform(0.2, 0.6), 0.3, 20}, draws.uniform(0, 3)});
    }
  }
  world.columns.push_back({{draws.uniform(-3, 3), draws.uniform(1.5, 2), 0}, {0, 0, 1}, 0.3});
  return world;
}

/// Where the body goes, and how it leans: along the hall and back in a slow turn.
RigidPose way_at(int tick, double lean_rad) {
  const double s = 0.08 * tick;
  const RigidPose flat{{-4.0 + s, 0.6 * std::sin(0.7 * s), 0.4 + 0.02 * s},
                       rt::exp_rotation({0, 0, 0.5 * std::sin(s)})};
  return {flat.p, flat.q * rt::exp_rotation({lean_rad * std::sin(1.3 * s), lean_rad * std::cos(s), 0})};
}

/// Wheels that are off by a part of each step.
struct Wheels {
  RigidPose pose;
  RigidPose last;

  mapping::OdometryHint to(const RigidPose& next, testing::Draws& draws) {
    const RigidPose step =
        mapping::after(mapping::inverse(mapping::laid_flat(last)), mapping::laid_flat(next));
    const double way = rt::norm(step.p), turn = rt::norm(rt::log_rotation(step.q));
    const rt::Vector3 slip{(0.003 + 0.1 * way) * draws.normal(), (0.003 + 0.1 * way) * draws.normal(), 0};
    const rt::Quaternion skid = rt::exp_rotation({0, 0, (0.002 + 0.05 * turn) * draws.normal()});
    pose = mapping::after(pose, {step.p + slip, rt::normalised(step.q * skid)});
    last = next;
    return {true, mapping::stood_up(pose, mapping::out_of_plane(next)), 0.01 + 0.2 * way, 0.01 + 0.1 * turn};
  }
};

mapping::Located locate_flat(testing::OwnedLocator& owned, const std::vector<rt::ScanPoint>& points,
                             rt::Nanoseconds stamp_ns, const mapping::OdometryHint& hint) {
  rt::PointScan scan;
  scan.header.stamp_ns = stamp_ns;
  scan.header.points = static_cast<std::uint32_t>(points.size());
  scan.points = points.data();
  return owned.part.locate(scan, hint);
}

double turn_between(const RigidPose& a, const RigidPose& b) {
  return rt::norm(rt::log_rotation(rt::conjugate(a.q) * b.q));
}
double flat_between(const RigidPose& a, const RigidPose& b) {
  return std::hypot(a.p.x - b.p.x, a.p.y - b.p.y);
}

/// Position and turn in the plane, off the truth, by the covariance of the result.
double squared_deviations(const mapping::Located& l, const RigidPose& truth) {
  constexpr int kIn[3] = {0, 1, 5};
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) c(i, k) = l.covariance[6 * kIn[i] + kIn[k]];
  }
  const rt::Vector3 turned = rt::log_rotation(rt::conjugate(truth.q) * l.T_map_sensor.q);
  const Eigen::Vector3d off(l.T_map_sensor.p.x - truth.p.x, l.T_map_sensor.p.y - truth.p.y, turned.z);
  return off.dot(testing::solved(c, off));
}

/// What 80 scans of a walk came to: the most that a pose was off, and how many were not placed.
struct Walked {
  double most_m = 0.0, most_rad = 0.0;
  int refused = 0;

  /// Of the way of 6.4 m at most 1 %.
  bool held() const { return most_m < 0.06 && most_rad < 0.015; }
};

Walked walk_through(const testing::RegistrationWorld& world, double lean, testing::Draws& draws) {
  testing::OwnedLocator owned(planar_config());
  REQUIRE(owned.arena.refused() == 0);
  Wheels wheels{mapping::laid_flat(way_at(0, lean)), way_at(0, lean)};
  Walked walked;
  for (int tick = 0; tick < 80; ++tick) {
    INFO("lean " << lean << ", scan " << tick);
    const RigidPose truth = way_at(tick, lean);
    const mapping::OdometryHint hint = wheels.to(truth, draws);
    const mapping::Located l =
        locate_flat(owned, one_row().scan(world, truth.p, truth.q, draws), (tick + 1) * kPlaneTick_ns, hint);
    if (!mapping::is_placed(l.verdict)) ++walked.refused;
    walked.most_m = std::max(walked.most_m, flat_between(l.T_map_sensor, truth));
    walked.most_rad = std::max(walked.most_rad, turn_between(l.T_map_sensor, truth));
    CHECK(std::fabs(l.T_map_sensor.p.z - hint.T_odom_sensor.p.z) < 1e-12);
    const mapping::OutOfPlane told = mapping::out_of_plane(hint.T_odom_sensor),
                              kept = mapping::out_of_plane(l.T_map_sensor);
    CHECK(rt::norm(rt::log_rotation(rt::conjugate(told.tilt) * kept.tilt)) < 1e-9);
    // What hangs the odometry on the map lies in the plane.
    CHECK(l.T_map_odom.p.z == 0.0);
    CHECK(l.T_map_odom.q.x == 0.0);
    CHECK(l.T_map_odom.q.y == 0.0);
    const RigidPose tied = mapping::after(l.T_map_odom, hint.T_odom_sensor);
    if (mapping::is_placed(l.verdict)) CHECK(rt::norm(tied.p - l.T_map_sensor.p) < 1e-9);
  }
  return walked;
}
}  // namespace

TEST_CASE("A lidar of one row is followed through a storey, and its height and tilt are the odometry's") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    INFO("seed " << seed);
    testing::Draws draws(seed);
    for (const double lean : {0.0, 0.05}) {
      const Walked walked = walk_through(storey(draws), lean, draws);
      CHECK(walked.refused <= 2);
      CHECK(walked.held());
    }
  }
}

// A map that is made on the way drifts: of 2,000 such walks (seeds 1 to 1,000, two each) 4 were not held, the
// worst was off by 6.4 cm and 15.7 mrad. That three of eight are not is a chance of one in two million.
TEST_CASE("In storeys drawn at random a lidar of one row is followed almost always") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  int lost = 0;
  for (int walk = 0; walk < 8; ++walk) {
    const Walked walked = walk_through(storey(draws), walk % 2 == 0 ? 0.0 : 0.05, draws);
    CHECK(walked.refused <= 2);
    CHECK(walked.most_m < 0.1);
    CHECK(walked.most_rad < 0.025);
    if (!walked.held()) ++lost;
  }
  CHECK(lost <= 2);
}

TEST_CASE("Along a corridor a lidar of one row holds nothing, and says so") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  for (int run = 0; run < 6; ++run) {
    const double yaw = draws.uniform(-3, 3), half = draws.uniform(0.8, 1.6);
    testing::RegistrationWorld world;
    world.boxes.push_back({{0, 0, 5}, {200, half, 20}, yaw});
    const rt::Vector3 along{std::cos(yaw), std::sin(yaw), 0}, across{-along.y, along.x, 0};
    testing::TestLidar lidar = one_row();
    lidar.most_m = 25.0;
    testing::OwnedLocator owned(planar_config());
    for (int tick = 0; tick < 25; ++tick) {
      INFO("corridor " << run << ", scan " << tick);
      const RigidPose truth{0.1 * tick * along, rt::exp_rotation({0, 0, yaw + 0.2 * std::sin(0.3 * tick)})};
      mapping::OdometryHint hint{true, truth, 0.03, 0.02};
      // Wheels that are 2 cm ahead all the time, and turned: across and yaw the scan knows better.
      hint.T_odom_sensor.p = hint.T_odom_sensor.p + 0.02 * along + (tick == 0 ? 0.0 : 0.03) * across;
      if (tick > 0) hint.T_odom_sensor.q = rt::exp_rotation({0, 0, 0.01}) * truth.q;
      const mapping::Located l =
          locate_flat(owned, lidar.scan(world, truth.p, truth.q, draws), (tick + 1) * kPlaneTick_ns, hint);
      if (tick < 2) continue;
      CHECK(l.verdict == LocateVerdict::accepted);
      REQUIRE(l.weak_moves == 1);
      CHECK(l.weak_turns == 0);
      const double cosine = l.weak_move[0].axis_map[0] * along.x + l.weak_move[0].axis_map[1] * along.y;
      CHECK(std::fabs(cosine) > 0.999);
      CHECK(l.weak_move[0].axis_map[2] == 0.0);
      CHECK(l.weak_move[0].sigma > 0.02);
      CHECK(l.weak_move[0].sigma < 0.06);
      const rt::Vector3 off = l.T_map_sensor.p - truth.p;
      CHECK(std::fabs(rt::dot(off, across)) < 0.015);
      CHECK(std::fabs(rt::dot(off, along)) < 0.1);
      CHECK(turn_between(l.T_map_sensor, truth) < 0.006);
    }
  }
}

TEST_CASE("In the middle of a round room a lidar of one row does not know which way it looks") {
  testing::Draws draws(7);
  testing::RegistrationWorld world;
  world.columns.push_back({{0, 0, 0}, {0, 0, 1}, 4.0});
  testing::OwnedLocator owned(planar_config());
  for (int tick = 0; tick < 8; ++tick) {
    const mapping::OdometryHint hint{true, {}, 0.02, 0.02};
    const mapping::Located l =
        locate_flat(owned, one_row().scan(world, {}, {}, draws), (tick + 1) * kPlaneTick_ns, hint);
    if (tick < 2) continue;
    CHECK(l.verdict == LocateVerdict::accepted);
    CHECK(l.weak_moves == 0);
    REQUIRE(l.weak_turns == 1);
    CHECK(l.weak_turn[0].axis_map[2] == 1.0);
    CHECK(l.weak_turn[0].sigma > 0.01);
  }
}

TEST_CASE("A lidar of one row that starts off by x, y and yaw is found, or refused, and never misplaced",
          "[heavy]") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  int found = 0, misplaced = 0, trials = 0;
  for (int run = 0; run < 12; ++run) {
    const testing::RegistrationWorld world = storey(draws);
    testing::OwnedLocator owned(planar_config());
    Wheels wheels{mapping::laid_flat(way_at(0, 0)), way_at(0, 0)};
    for (int tick = 0; tick < 40; ++tick) {
      const RigidPose truth = way_at(tick, 0);
      static_cast<void>(locate_flat(owned, one_row().scan(world, truth.p, truth.q, draws),
                                    (tick + 1) * kPlaneTick_ns, wheels.to(truth, draws)));
    }
    for (int tick = 40; tick < 46; ++tick) {
      const RigidPose truth = way_at(tick, 0);
      mapping::OdometryHint hint{true, truth, 10.0, 10.0};
      const double turn = draws.uniform(-3.1, 3.1);
      hint.T_odom_sensor = mapping::after(mapping::inverse(owned.part.located().T_map_odom), truth);
      hint.T_odom_sensor.p =
          hint.T_odom_sensor.p + draws.uniform(0, 0.5) * rt::Vector3{std::cos(turn), std::sin(turn), 0};
      hint.T_odom_sensor.q =
          rt::normalised(rt::exp_rotation({0, 0, draws.uniform(-0.35, 0.35)}) * hint.T_odom_sensor.q);
      const mapping::Located l = locate_flat(owned, one_row().scan(world, truth.p, truth.q, draws),
                                             (tick + 1) * kPlaneTick_ns, hint);
      ++trials;
      if (l.verdict != LocateVerdict::accepted) continue;
      const bool right =
          flat_between(l.T_map_sensor, truth) < 0.08 && turn_between(l.T_map_sensor, truth) < 0.02;
      ++(right ? found : misplaced);
      if (!right) break;
    }
  }
  INFO(found << " of " << trials << " found, " << misplaced << " misplaced");
  CHECK(misplaced == 0);
  CHECK(found >= 9 * trials / 10);
}

TEST_CASE("What a lidar of one row says of its errors is what they are", "[heavy]") {
  const auto seed = std::random_device{}();
  INFO("seed " << seed);
  testing::Draws draws(seed);
  double sum = 0.0;
  int count = 0;
  for (int run = 0; run < 40; ++run) {
    const testing::RegistrationWorld world = storey(draws);
    testing::OwnedLocator owned(planar_config());
    // A map of true poses; then one scan whose odometry is off by what it says.
    for (int tick = 0; tick < 12; ++tick) {
      const RigidPose truth = way_at(tick, 0);
      const mapping::OdometryHint hint{true, truth, 1e-6, 1e-6};
      static_cast<void>(locate_flat(owned, one_row().scan(world, truth.p, truth.q, draws),
                                    (tick + 1) * kPlaneTick_ns, hint));
    }
    const RigidPose truth = way_at(12, 0);
    mapping::OdometryHint hint{true, truth, 0.05, 0.03};
    hint.T_odom_sensor.p =
        hint.T_odom_sensor.p + rt::Vector3{0.05 * draws.normal(), 0.05 * draws.normal(), 0};
    hint.T_odom_sensor.q = rt::exp_rotation({0, 0, 0.03 * draws.normal()}) * hint.T_odom_sensor.q;
    const mapping::Located l =
        locate_flat(owned, one_row().scan(world, truth.p, truth.q, draws), 13 * kPlaneTick_ns, hint);
    if (l.verdict != LocateVerdict::accepted) continue;
    sum += squared_deviations(l, truth);
    ++count;
  }
  INFO("mean squared deviations of three unknowns: " << sum / count << " of " << count);
  CHECK(count >= 38);
  CHECK(sum / count > 0.5);
  CHECK(sum / count < 9.0);
}

TEST_CASE("In the plane, too, results do not depend on the order of returns, nor on the heap") {
  testing::Draws draws(3);
  const testing::RegistrationWorld world = storey(draws);
  testing::OwnedLocator one(planar_config()), other(planar_config());
  std::uint64_t calls = 0;
  for (int tick = 0; tick < 12; ++tick) {
    const RigidPose truth = way_at(tick, 0.03);
    const mapping::OdometryHint hint{tick % 4 != 3, truth, 0.05, 0.03};
    std::vector<rt::ScanPoint> scan = one_row().scan(world, truth.p, truth.q, draws);
    if (tick == 8) scan.resize(30);
    std::vector<rt::ScanPoint> shuffled = scan;
    testing::shuffle(shuffled, draws);
    const rt::posix::HeapTrapScope scope;
    const std::uint64_t a = rt::digest_of(locate_flat(one, scan, (tick + 1) * kPlaneTick_ns, hint));
    calls += scope.calls();
    CHECK(a == rt::digest_of(locate_flat(other, shuffled, (tick + 1) * kPlaneTick_ns, hint)));
    if (tick == 8) CHECK(one.part.located().verdict == LocateVerdict::few_returns);
  }
  if (rt::posix::kHeapTrapAvailable) CHECK(calls == 0);
}
