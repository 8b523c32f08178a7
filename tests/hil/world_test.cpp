// SPDX-License-Identifier: BSD-3-Clause
// The ray caster against closed forms, marching through an independent model, and its own brute force.
#include "hil/world.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hil/random.hpp"
#include "oracle.hpp"
#include "tests/hil/units.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

void must(Status status) { REQUIRE(status == Status::ok); }

Vec3 direction(double azimuth, double elevation) {
  return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
          std::sin(elevation)};
}

Vec3 random_direction(Random& random) {
  const double azimuth = random.uniform(-kPi, kPi);
  const double elevation = random.uniform(-0.8, 0.8);
  return direction(azimuth, elevation);
}

void fill(World& world, Random& random, int solids, double span) {
  for (int i = 0; i < solids; ++i) {
    const double kind = random.uniform();
    BoxShape shape;
    shape.center_x_m = random.uniform(-span, span);
    shape.center_y_m = random.uniform(-span, span);
    shape.yaw_rad = random.uniform() < 0.3 ? 0.0 : random.uniform(-kPi, kPi);
    shape.length_m = random.uniform(0.05, 3.0);
    shape.width_m = random.uniform(0.05, 1.5);
    shape.bottom_m = random.uniform() < 0.5 ? 0.0 : random.uniform(0.0, 1.0);
    shape.top_m = shape.bottom_m + random.uniform(0.05, 2.0);
    if (kind < 0.5) {
      must(world.add(make_box(shape)));
    } else if (kind < 0.75) {
      must(world.add(make_wedge(shape)));
    } else {
      must(world.add(make_cylinder(shape.center_x_m, shape.center_y_m, 0.5 * shape.width_m, shape.bottom_m,
                                   shape.top_m)));
    }
  }
  must(world.finalize());
}

bool same(const Hit& a, const Hit& b) {
  return a.range_m == b.range_m && a.solid == b.solid && a.normal.x == b.normal.x &&
         a.normal.y == b.normal.y && a.normal.z == b.normal.z && a.reflectivity == b.reflectivity;
}

}  // namespace

TEST_CASE("rays meet box, cylinder, ramp and ground where the closed form says") {
  World world;
  must(world.add(make_box({5, 0, 0, 2, 2, 0, 1}, 77)));
  must(world.add(make_cylinder(0, 6, 1.5, 0, 2, 88)));
  must(world.add(make_wedge({-6, 0, kPi, 4, 2, 0, 1}, 99)));  // rises from x = -4 to x = -8
  must(world.finalize());

  const Hit box = world.cast({0, 0.25, 0.5}, {1, 0, 0}, 50);
  CHECK(box.range_m == 4.0);
  CHECK(box.solid == 0);
  CHECK(box.reflectivity == 77);
  CHECK(box.normal.x == -1.0);

  const Hit round = world.cast({0.9, 0, 1}, {0, 1, 0}, 50);
  CHECK(round.range_m == Approx(6.0 - std::sqrt(1.5 * 1.5 - 0.9 * 0.9)).epsilon(1e-15));
  CHECK(round.normal.x == Approx(0.9 / 1.5));

  const Hit ramp = world.cast({0, 0, 0.5}, {-1, 0, 0}, 50);
  CHECK(ramp.range_m == Approx(6.0).epsilon(1e-14));
  CHECK(ramp.normal.x == Approx(0.25 / std::sqrt(1.0625)));
  CHECK(ramp.normal.z == Approx(1.0 / std::sqrt(1.0625)));

  const Hit ground = world.cast({0, 0, 2}, direction(0.7, -0.5), 50);
  CHECK(ground.solid == Hit::kGround);
  CHECK(ground.range_m == Approx(2.0 / std::sin(0.5)).epsilon(1e-15));

  const Hit over = world.cast({0, 0, 1.5}, {1, 0, 0}, 50);
  CHECK_FALSE(over);
  CHECK(over.range_m == 50.0);
  CHECK_FALSE(world.cast({0, 0, 0.5}, {1, 0, 0}, 3.999));
  CHECK(world.cast({5, 0, 0.5}, {1, 0, 0}, 50).range_m == 0.0);   // from inside
  CHECK(world.cast({0, 0, -0.1}, {0, 0, 1}, 50).range_m == 0.0);  // from below the ground
}

TEST_CASE("a turned box is met where the box is met by the turned ray") {
  World straight;
  World turned;
  constexpr double kYaw = 0.77;
  must(straight.add(make_box({3, 1, 0, 2, 1, 0.2, 1.2})));
  const double c = std::cos(kYaw);
  const double s = std::sin(kYaw);
  must(turned.add(make_box({3 * c - s, 3 * s + c, kYaw, 2, 1, 0.2, 1.2})));
  must(straight.finalize());
  must(turned.finalize());
  Random random(5);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const double z = random.uniform(0.1, 1.5);
    const Vec3 d = direction(random.uniform(-0.4, 0.9), random.uniform(-0.3, 0.3));
    const Hit a = straight.cast({0, 0, z}, d, 20);
    const Hit b = turned.cast({0, 0, z}, {c * d.x - s * d.y, s * d.x + c * d.y, d.z}, 20);
    REQUIRE(a.solid == b.solid);
    REQUIRE(a.range_m == Approx(b.range_m).epsilon(1e-12));
    hits += a.solid == 0 ? 1 : 0;
  }
  CHECK(hits > 300);
}

TEST_CASE("no ray passes through anything, and none stops in free space", "[heavy]") {
  Random random(11);
  constexpr double kStep = 0.004;
  int solid_hits = 0;
  for (int scene = 0; scene < 6; ++scene) {
    INFO("scene " << scene << ", seed 11");
    World world;
    fill(world, random, 14, 4.0);
    for (int i = 0; i < 400; ++i) {
      const double x = random.uniform(-5, 5);
      const double y = random.uniform(-5, 5);
      const double z = random.uniform(0.05, 2.5);
      const Vec3 origin{x, y, z};
      const Vec3 d = random_direction(random);
      const Hit hit = world.cast(origin, d, 8.0);
      // All points before the hit are free ...
      for (double t = 0.0; t < hit.range_m - 1e-9; t += kStep) {
        if (oracle::world_depth(world, origin + t * d) <= -1e-9) {
          FAIL("the ray is already in a solid at " << t << " m, but the answer is " << hit.range_m << " m");
        }
      }
      if (!hit || hit.range_m == 0.0) continue;
      // ... the hit lies on a surface, on the side that the normal says.
      const Vec3 p = origin + hit.range_m * d;
      const double depth = hit.solid == Hit::kGround
                               ? p.z
                               : oracle::depth(world.solid(static_cast<std::size_t>(hit.solid)), p);
      REQUIRE(std::fabs(depth) < 1e-12);
      REQUIRE(norm(hit.normal) == Approx(1.0).epsilon(1e-12));
      REQUIRE(dot(hit.normal, d) < 0.0);
      if (hit.solid >= 0) {
        ++solid_hits;
        const Solid& solid = world.solid(static_cast<std::size_t>(hit.solid));
        REQUIRE(oracle::depth(solid, p + 1e-6 * hit.normal) == Approx(1e-6).epsilon(1e-3));
      }
    }
  }
  CHECK(solid_hits > 200);
}

TEST_CASE("the broad phase changes no bit of any answer") {
  Random random(23);
  int hits = 0;
  for (int scene = 0; scene < 12; ++scene) {
    World world;
    fill(world, random, 10 + 20 * scene, 9.0);
    for (int i = 0; i < 1500; ++i) {
      const double x = random.uniform(-14, 14);
      const double y = random.uniform(-14, 14);
      const double z = random.uniform(-0.1, 3.0);
      Vec3 d = random_direction(random);
      if (i % 5 == 1) d = {i % 2 == 0 ? 1.0 : -1.0, 0, 0};
      if (i % 5 == 2) d = {0, i % 2 == 0 ? 1.0 : -1.0, 0};
      if (i % 50 == 3) d = {0, 0, -1};
      if (i % 50 == 4) d = {1e-200, 1.0, 1e-310};
      const Hit fast = world.cast({x, y, z}, d, 25.0);
      const Hit slow = world.cast_brute_force({x, y, z}, d, 25.0);
      INFO("scene " << scene << " ray " << i << ": " << fast.range_m << " against " << slow.range_m);
      REQUIRE(same(fast, slow));
      hits += fast.solid >= 0 ? 1 : 0;
    }
  }
  CHECK(hits > 3000);
}

TEST_CASE("rays along the edges of cells and solids find what they touch") {
  World world;
  // 33 equal boxes in a row: their edges fall close to the cells' edges, with all their roundings.
  for (int i = 0; i < 33; ++i) must(world.add(make_box({0.1 * i, 0.1 * i, 0, 0.1, 0.1, 0, 1})));
  must(world.finalize());
  for (int i = -1; i <= 34; ++i) {
    for (const double shift : {-0.05, -0.05 + 1e-12, 0.0, 0.05, 0.05 - 1e-12}) {
      const double at = 0.1 * i + shift;
      CHECK(same(world.cast({at, -3, 0.5}, {0, 1, 0}, 20),
                 world.cast_brute_force({at, -3, 0.5}, {0, 1, 0}, 20)));
      CHECK(same(world.cast({9, at, 0.5}, {-1, 0, 0}, 20),
                 world.cast_brute_force({9, at, 0.5}, {-1, 0, 0}, 20)));
      const Vec3 diagonal = (1.0 / std::sqrt(2.0)) * Vec3{1, 1, 0};
      CHECK(same(world.cast({at - 5, -5, 0.5}, diagonal, 20),
                 world.cast_brute_force({at - 5, -5, 0.5}, diagonal, 20)));
    }
  }
}

TEST_CASE(
    "of two faces in one plane the solid that was added first is reported, whatever cell is seen first") {
  World world;
  must(world.add(make_box({5.5, 0.75, 0, 1, 0.2, 0, 1})));  // alone in its row of cells
  must(world.add(make_box({6.0, 0, 0, 2, 20, 0, 1})));
  must(world.add(make_box({-9.3, 0, 0, 1, 1, 0, 1})));  // moves the face into the middle of a cell
  must(world.finalize());
  int small = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 d = direction(0.001 * (i - 2000) * 0.7, 0.0);
    const double y = 0.7 - 5.0 * d.y / d.x + 0.00004 * (i - 2000);
    const Hit fast = world.cast({0, y, 0.5}, d, 30.0);
    REQUIRE(same(fast, world.cast_brute_force({0, y, 0.5}, d, 30.0)));
    small += fast.solid == 0 ? 1 : 0;
  }
  CHECK(small > 1000);
}

TEST_CASE("terrain is the highest drivable roof, else the ground") {
  World world;
  must(world.add(make_wedge({2, 0, 0, 2, 2, 0, 0.5})));
  must(world.add(make_box({4, 0, 0, 2, 2, 0, 0.5}, 100, true)));
  must(world.add(make_box({0, 5, 0, 2, 2, 0, 0.9})));  // not drivable
  must(world.finalize());
  CHECK(world.terrain_height(0.5, 0) == 0.0);
  CHECK(world.terrain_height(2.0, 0.3) == Approx(0.25));
  CHECK(world.terrain_height(2.9, -0.9) == Approx(0.475));
  CHECK(world.terrain_height(4.0, 0) == 0.5);
  CHECK(world.terrain_height(4.0, 1.01) == 0.0);
  CHECK(world.terrain_height(0, 5) == 0.0);
  CHECK(world.terrain_height(100, -100) == 0.0);
}

TEST_CASE("an outline is blocked exactly when it shares points with a solid") {
  Random random(31);
  int blocked = 0;
  int free = 0;
  for (int i = 0; i < 600; ++i) {
    World world;
    const double yaw = random.uniform(-kPi, kPi);
    const double x = random.uniform(-1.2, 1.2);
    const double y = random.uniform(-1.2, 1.2);
    if (i % 3 == 0) {
      must(world.add(make_cylinder(x, y, random.uniform(0.05, 0.5), 0, 1)));
    } else {
      const double length = random.uniform(0.05, 1.0);
      must(world.add(make_box({x, y, yaw, length, 0.3, 0, 1})));
    }
    must(world.finalize());
    const double heading = random.uniform(-kPi, kPi);
    const Footprint outline{0, 0, std::cos(heading), std::sin(heading), 0.4, 0.25, 0.1, 0.4};
    // Brute force: a fine raster over the outline.
    double deepest = 1.0;
    for (int a = -40; a <= 40; ++a) {
      for (int b = -25; b <= 25; ++b) {
        const double u = 0.01 * a;
        const double v = 0.01 * b;
        const Vec3 p{outline.cos_yaw * u - outline.sin_yaw * v, outline.sin_yaw * u + outline.cos_yaw * v,
                     0.2};
        deepest = std::min(deepest, oracle::depth(world.solid(0), p));
      }
    }
    if (deepest < -1e-9) {
      CHECK(world.blocked(outline));
      ++blocked;
    } else if (deepest > 0.01) {  // between the two the raster cannot tell
      CHECK_FALSE(world.blocked(outline));
      ++free;
    }
    Footprint above = outline;
    above.bottom_m = 1.0;
    above.top_m = 1.4;
    CHECK_FALSE(world.blocked(above));
  }
  CHECK(blocked > 100);
  CHECK(free > 100);
}

TEST_CASE("a world refuses what is not a solid, and more than it can hold") {
  World world;
  CHECK(world.add(make_box({0, 0, 0, 0, 1, 0, 1})) == Status::out_of_range);
  CHECK(world.add(make_box({0, 0, 0, 1, 1, 1, 1})) == Status::out_of_range);
  CHECK(world.add(make_box({std::numeric_limits<double>::quiet_NaN(), 0, 0, 1, 1, 0, 1})) ==
        Status::not_finite);
  CHECK(world.size() == 0);
  for (std::size_t i = 0; i < World::kMaxSolids; ++i) {
    must(world.add(make_box({0.01 * static_cast<double>(i), 0, 0, 50, 50, 0, 1})));
  }
  CHECK(world.add(make_box({0, 0, 0, 1, 1, 0, 1})) == Status::full);
  CHECK(world.finalize() == Status::full);  // 256 solids in every cell
  // Without a broad phase the answers are still right.
  CHECK(world.cast({-100, 0, 0.5}, {1, 0, 0}, 200).range_m == Approx(75.0));
}
