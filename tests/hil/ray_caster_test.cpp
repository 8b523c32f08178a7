// SPDX-License-Identifier: BSD-3-Clause
// The ray caster of all range sensors: the robot's outline against an independent distance function, the
// whole against its brute force, and what is no pose.
#include "hil/ray_caster.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hil/random.hpp"
#include "oracle.hpp"
#include "rt/posix/heap_trap.hpp"
#include "tests/hil/sensor_bench.hpp"

namespace sortie::hil {
namespace {

constexpr double kCasterNan = std::numeric_limits<double>::quiet_NaN();

// Signed distance to the extruded hull of two circles (its two-dimensional part after I. Quilez), negative
// inside, in the frame of the plant's own collision body.
double pair_depth(const rt::convex::Convex& body, const Vec3& p) {
  const rt::Vector3 d{p.x - body.p_world_m.x, p.y - body.p_world_m.y, p.z - body.p_world_m.z};
  const double* m = body.R_world_body.m;
  const double along = m[0] * d.x + m[3] * d.y + m[6] * d.z;
  const double axle = m[1] * d.x + m[4] * d.y + m[7] * d.z;
  const double across = std::fabs(m[2] * d.x + m[5] * d.y + m[8] * d.z);
  const double b = (body.radius_m[0] - body.radius_m[1]) / body.length_m;
  const double a = std::sqrt(1.0 - b * b);
  const double k = a * along - b * across;
  double flat = a * across + b * along - body.radius_m[0];
  if (k < 0.0) flat = std::hypot(along, across) - body.radius_m[0];
  if (k > a * body.length_m) flat = std::hypot(along - body.length_m, across) - body.radius_m[1];
  return std::fmax(flat, std::fabs(axle) - body.half_m.y);
}

double box_depth(const rt::convex::Convex& body, const Vec3& p) {
  return std::fmax(std::fabs(p.x - body.p_world_m.x) - body.half_m.x,
                   std::fmax(std::fabs(p.y - body.p_world_m.y) - body.half_m.y,
                             std::fabs(p.z - body.p_world_m.z) - body.half_m.z));
}

// The vehicle as its contacts know it, moved to the robot's own frame.
struct OutlineTwin {
  explicit OutlineTwin(const double (&flipper_rad)[kFlippers]) {
    const VehicleModel model{VehicleConfig{}};
    MassState state;
    model.mass_at(flipper_rad, state);
    for (int part = 0; part < kParts; ++part) {
      parts[part] = model.shape(part, state);
      parts[part].p_world_m.z += kPlantHeight_m;
    }
  }
  double depth(int part, const Vec3& p) const {
    return part == 0 ? box_depth(parts[part], p) : pair_depth(parts[part], p);
  }
  double depth(const Vec3& p) const {
    double least = depth(0, p);
    for (int part = 1; part < kParts; ++part) least = std::fmin(least, depth(part, p));
    return least;
  }
  rt::convex::Convex parts[kParts];
};

}  // namespace

TEST_CASE("the robot's outline is met where an independent distance function says, at any flipper angle",
          "[heavy]") {
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  Random random(71, 1);
  INFO("seed 71");
  int hits[kParts]{};
  for (int round = 0; round < 40; ++round) {
    double angles[kFlippers];
    for (double& angle : angles) angle = random.uniform(-kPi, kPi);
    const OutlineTwin twin(angles);
    const ShellPosture posture = VehicleShell::posture(angles);
    for (int i = 0; i < 60; ++i) {
      const Vec3 origin = point_anywhere(random, 1.2, 1.2, 1.0);
      const Vec3 to = point_anywhere(random, 0.6, 0.35, 0.3) - origin;
      const Vec3 direction = (1.0 / norm(to)) * to;
      ShellHit hit;
      const bool met = shell.meet({origin, direction}, posture, 3.0, hit);
      const double free_m = met ? hit.range_m : 3.0;
      for (double t = 0.0; t < free_m - 1e-9; t += 0.004) {
        if (twin.depth(origin + t * direction) < -1e-9)
          FAIL("a part lies before the answer, at " << t << " m");
      }
      if (!met) continue;
      const int part = static_cast<int>(hit.part);
      ++hits[part];
      const Vec3 p = origin + hit.range_m * direction;
      if (hit.range_m == 0.0) {
        REQUIRE(twin.depth(part, p) <= 1e-12);
        continue;
      }
      REQUIRE(std::fabs(twin.depth(part, p)) < 1e-9);
      REQUIRE(norm(hit.normal) == Approx(1.0).epsilon(1e-12));
      REQUIRE(dot(hit.normal, direction) < 0.0);
      REQUIRE(twin.depth(part, p + 1e-6 * hit.normal) == Approx(1e-6).epsilon(1e-3));
    }
  }
  for (const int count : hits) CHECK(count > 10);
}

TEST_CASE("one wheel within the other is that other wheel alone") {
  const WheelPair pair{0.2, 0.05, 0.1, 0.1};
  const Contact tip = intersect(Ray{{1, 0, 0}, {-1, 0, 0}}, pair);
  CHECK(tip.range_m == Approx(0.8).epsilon(1e-14));
  CHECK(tip.normal.x == Approx(1.0));
  CHECK(std::isinf(intersect(Ray{{1, 0.11, 0}, {-1, 0, 0}}, pair).range_m));
  CHECK(intersect(Ray{{0, 1, 0.1}, {0, -1, 0}}, pair).range_m == Approx(0.9));
  CHECK(intersect(Ray{{0.05, 0.05, 0.05}, {0, 0, 1}}, pair).range_m == 0.0);
}

TEST_CASE("what the caster skips changes no answer, with tilted solids and the robot in the way") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster with_robot(world, &shell);
  const RayCaster without(world);
  Random random(72, 1);
  INFO("seed 72");
  int own = 0;
  int solid = 0;
  for (int i = 0; i < 20000; ++i) {
    const SensorMount mount{point_anywhere(random, 0.4, 0.3, 0.3) + Vec3{0, 0, 0.45}, turn_anywhere(random)};
    BodyInstant body{point_anywhere(random, 3.0, 3.0, 0.5) + Vec3{0, 0, 0.5}, turn_anywhere(random)};
    for (double& angle : body.flipper_rad) angle = random.uniform(-kPi, kPi);
    RayCaster::Aim aim;
    REQUIRE(with_robot.aim(mount, body, aim) == Status::ok);
    const Vec3 direction = unit_anywhere(random);
    const RangeHit fast = with_robot.cast(aim, direction, 12.0);
    const RangeHit slow = with_robot.cast_brute_force(aim, direction, 12.0);
    REQUIRE(fast.range_m == slow.range_m);
    REQUIRE(fast.solid == slow.solid);
    REQUIRE(fast.cos_incidence == slow.cos_incidence);
    REQUIRE(fast.cos_incidence <= 1.0 + 1e-12);
    // Without the robot a ray goes on, and meets what the world alone says.
    const RangeHit through = without.cast(aim, direction, 12.0);
    const Hit plain = world.cast(aim.p_world_sensor_m, rotate(aim.q_world_sensor, direction), 12.0);
    REQUIRE(through.range_m == plain.range_m);
    REQUIRE(through.solid == plain.solid);
    REQUIRE_FALSE(through.own());
    REQUIRE(through.range_m >= fast.range_m);
    if (!fast.own()) REQUIRE(through.solid == fast.solid);
    own += fast.own() ? 1 : 0;
    solid += fast.solid >= 0 ? 1 : 0;
  }
  CHECK(own > 2000);
  CHECK(solid > 2000);
}

TEST_CASE("incidence is the angle to the surface, and what is met has its number") {
  World world;
  REQUIRE(world.add(make_box({5, 0, 0, 2, 20, 0, 3}, 77)) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  const RayCaster caster(world);
  RayCaster::Aim aim;
  REQUIRE(caster.aim({{0, 0, 1}, {}}, {}, aim) == Status::ok);
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.1 * i;
    const RangeHit hit = caster.cast(aim, {std::cos(angle), std::sin(angle), 0}, 30.0);
    CHECK(hit.solid == 0);
    CHECK(hit.reflectivity == 77);
    CHECK(hit.cos_incidence == Approx(std::cos(angle)).epsilon(1e-14));
    CHECK(hit.range_m == Approx(4.0 / std::cos(angle)).epsilon(1e-14));
  }
  const RangeHit ground = caster.cast(aim, {0.6, 0, -0.8}, 30.0);
  CHECK(ground.solid == Hit::kGround);
  CHECK(ground.cos_incidence == Approx(0.8));
  CHECK_FALSE(caster.cast(aim, {0, 0, 1}, 30.0));
}

TEST_CASE("flippers between two instants are where a straight blend puts them") {
  SensorStep step = resting_step(0, {});
  for (int f = 0; f < kFlippers; ++f) step.after_flipper_rad[f] = 0.1 * (f + 1);
  BodyInstant body;
  REQUIRE(body_at(step, kMs / 4, body) == Status::ok);
  for (int f = 0; f < kFlippers; ++f) CHECK(body.flipper_rad[f] == Approx(0.025 * (f + 1)).epsilon(1e-14));
}

TEST_CASE("what is no pose is refused and leaves the aim as it was") {
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(world, &shell);
  RayCaster::Aim aim;
  aim.p_world_sensor_m = {7, 8, 9};
  const auto refused = [&](const SensorMount& mount, const BodyInstant& body) {
    return caster.aim(mount, body, aim) == Status::not_finite && aim.p_world_sensor_m.x == 7;
  };
  CHECK(refused({{kCasterNan, 0, 0}, {}}, {}));
  CHECK(refused({{}, {0, 0, 0, 0}}, {}));
  CHECK(refused({}, {{0, kCasterNan, 0}, {}}));
  CHECK(refused({}, {{}, {kCasterNan, 0, 0, 0}}));
  CHECK(refused({}, {{}, {2, 0, 0, 0}}));
  CHECK(refused({}, {{}, {}, {0, 0, kCasterNan, 0}}));
  BodyInstant body;
  for (int member = 0; member < 5; ++member) {
    SensorStep step = resting_step(0, {});
    if (member == 0) step.before.p_world_body_m.z = kCasterNan;
    if (member == 1) step.after.p_world_body_m.x = kCasterNan;
    if (member == 2) step.before.q_world_body = {0, 0, 0, 0};
    if (member == 3) step.after.q_world_body.y = kCasterNan;
    if (member == 4) step.before_flipper_rad[3] = kCasterNan;
    CHECK(body_at(step, kMs / 2, body) == Status::not_finite);
  }
}

TEST_CASE("aiming and casting take nothing from the heap") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: this build cannot count heap calls");
    return;
  }
  const World world = sensor_yard();
  const VehicleShell shell(VehicleConfig{}, kPlantHeight_m);
  const RayCaster caster(world, &shell);
  Random random(73, 1);
  int met = 0;
  const rt::posix::HeapTrapScope scope;
  for (int i = 0; i < 2000; ++i) {
    RayCaster::Aim aim;
    met +=
        caster.aim({{0, 0, 0.5}, {}}, {}, aim) == Status::ok && caster.cast(aim, unit_anywhere(random), 12.0)
            ? 1
            : 0;
  }
  CHECK(scope.calls() == 0);
  CHECK(met > 500);
}

}  // namespace sortie::hil
