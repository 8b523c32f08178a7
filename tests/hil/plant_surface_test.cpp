// SPDX-License-Identifier: BSD-3-Clause
// Contact surface motion in its singular cases, and the equality with the published tangents in the others.
#include <catch2/catch.hpp>

#include "hil/plant/surface_motion.hpp"
#include "hil/random.hpp"

using namespace sortie::hil;

namespace {

VehicleConfig config() { return {}; }
Vec3 target(const Vec3& point, const Vec3& normal, double left, double right) {
  return surface_target(point, normal, 1, belt_motion(left, right, 0.0, config()), config());
}

}  // namespace

TEST_CASE("surface motion: omega n x r about the turning centre, for any circle", "[plant]") {
  Random random(5);
  for (int i = 0; i < 10000; ++i) {
    const double left = random.uniform(-1, 1);
    const double right = random.uniform(-1, 1);
    const BeltMotion belts = belt_motion(left, right, 0.0, config());
    const double tilt = random.uniform(-1.2, 1.2);
    const Vec3 normal{std::sin(tilt), 0, std::cos(tilt)};
    const Vec3 point{random.uniform(-0.4, 0.4), 0.2, -0.07};
    const Vec3 icr{0, belts.forward_m_s / belts.turn_rad_s, 0};
    const Vec3 published = belts.turn_rad_s * cross(normal, point - icr);
    CAPTURE(left, right, tilt);
    CHECK(norm(target(point, normal, left, right) - published) < 1e-9);
  }
}

TEST_CASE("surface motion: singular cases", "[plant]") {
  const Vec3 up{0, 0, 1};
  SECTION("straight is the belt's speed along it, and the limit of ever wider circles") {
    CHECK(norm(target({0.2, 0.2, -0.07}, up, 0.3, 0.3) - Vec3{0.3, 0, 0}) < 1e-15);
    const Vec3 tilted{0, 0.6, 0.8};
    CHECK(norm(target({0.2, 0.2, -0.07}, tilted, 0.3, 0.3)) == Approx(0.3));
    double before = 1.0;
    for (double turn = 1e-1; turn > 1e-12; turn *= 0.1) {
      const double off = norm(target({0.2, 0.2, -0.07}, up, 0.3, 0.3 + turn) - Vec3{0.3, 0, 0});
      CHECK(off < 0.2 * before);
      before = off;
    }
  }
  SECTION("a contact at the turning centre has no tangent and needs none") {
    const double belt = 0.1985;
    CHECK(norm(target({0, 0, -0.07}, up, -belt, belt)) < 1e-15);
    CHECK(norm(target({1e-12, 0, -0.07}, up, -belt, belt)) < 1e-11);
  }
  SECTION("the side of a track does not drive, and fades in without a jump") {
    CHECK(norm(target({0.2, 0.25, 0}, {0, 1, 0}, 0.3, 0.3)) < 1e-15);
    CHECK(norm(target({0.2, 0.25, 0}, {0, -1, 0}, -0.3, 0.3)) < 1e-15);
    double before = 0.0;
    for (int i = 0; i <= 2000; ++i) {
      const double a = 1e-4 * i;
      const double speed = norm(target({0.2, 0.25, 0}, {0, std::cos(a), std::sin(a)}, 0.3, 0.3));
      CHECK(speed - before < 4e-4);
      CHECK(speed <= 0.3 + 1e-12);
      before = speed;
    }
    CHECK(before == Approx(0.3));
  }
  SECTION("turning centre inside the footprint: the two sides go opposite ways") {
    const Vec3 left = target({0, 0.2, -0.07}, up, -0.1, 0.2);
    const Vec3 right = target({0, -0.2, -0.07}, up, -0.1, 0.2);
    CHECK(left.x < 0.0);
    CHECK(right.x > 0.0);
  }
  SECTION("both signs of omega: mirrored belts give the mirrored field") {
    const Vec3 a = target({0.1, 0.2, -0.07}, up, 0.1, 0.3);
    const Vec3 b = target({0.1, -0.2, -0.07}, up, 0.3, 0.1);
    CHECK(a.x == b.x);
    CHECK(a.y == -b.y);
  }
}
