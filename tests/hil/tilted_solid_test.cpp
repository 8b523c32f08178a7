// SPDX-License-Identifier: BSD-3-Clause
// Solids in any attitude against the upright ones, against half-spaces written down apart, and a plant's
// scene as rays see it.
#include <catch2/catch.hpp>
#include <cmath>

#include "hil/plant/course.hpp"
#include "hil/plant/obstacles.hpp"
#include "hil/random.hpp"
#include "oracle.hpp"
#include "tests/hil/plant_trials.hpp"

using namespace sortie;
using namespace sortie::hil;

namespace {

// True if the point lies in the solid or on its surface.
bool contains(const Solid& solid, const Vec3& point_m) {
  if (!is_tilted(solid))
    return point_m.z >= solid.bottom_m && point_m.z <= roof_height(solid, point_m.x, point_m.y);
  const Vec3 way = point_m - Vec3{solid.center_x_m, solid.center_y_m, 0.5 * (solid.bottom_m + solid.top_m)};
  const Vec3 p{dot(solid.axes.x, way), dot(solid.axes.y, way), dot(solid.axes.z, way)};
  if (std::fabs(p.y) > solid.half_m.y) return false;
  if (solid.kind == SolidKind::tilted_cylinder)
    return p.x * p.x + p.z * p.z <= solid.half_m.x * solid.half_m.x;
  return std::fabs(p.x) <= solid.half_m.x && std::fabs(p.z) <= solid.half_m.z;
}

Vec3 random_unit(Random& random) {
  const Vec3 v = random_vector(random, 1.0);
  const double length = norm(v);
  return length > 0.1 ? (1.0 / length) * v : Vec3{0, 0, -1};
}

Solid random_tilted(Random& random, bool round) {
  const Vec3 center = random_vector(random, 2.0) + Vec3{0, 0, 2.5};
  const Axes axes = axes_of(random_attitude(random));
  const double a = random.uniform(0.05, 0.8);
  const double b = random.uniform(0.05, 0.8);
  const double c = random.uniform(0.05, 0.8);
  return round ? make_tilted_cylinder(center, axes, a, b) : make_tilted_box(center, axes, {a, b, c});
}

}  // namespace

TEST_CASE("a tilted solid that stands upright answers as the upright one") {
  Random random(3, 1);
  for (int i = 0; i < 400; ++i) {
    const double yaw = random.uniform(-3, 3);
    const double high = random.uniform(0.1, 2);
    const BoxShape shape{random.uniform(-1, 1), 0.3, yaw, random.uniform(0.1, 2), 0.7, 0.5, 0.5 + high};
    const Solid box = make_box(shape);
    const Vec3 middle{shape.center_x_m, shape.center_y_m, 0.5 + 0.5 * high};
    const Solid same_box = make_tilted_box(middle, axes_of(from_yaw_pitch_roll(yaw, 0, 0)),
                                           {0.5 * shape.length_m, 0.35, 0.5 * high});
    // The tilted cylinder's axis is y: a quarter turn about x sets it upright.
    const Solid drum = make_cylinder(middle.x, middle.y, 0.4, 0.5, 0.5 + high);
    const Solid same_drum = make_tilted_cylinder(
        middle, axes_of(from_yaw_pitch_roll(yaw, 0, 1.5707963267948966)), 0.4, 0.5 * high);
    const Ray ray{random_vector(random, 3.0) + Vec3{0, 0, 1}, random_unit(random)};
    for (const auto& [upright, tilted] : {std::pair{box, same_box}, std::pair{drum, same_drum}}) {
      const Contact a = intersect(ray, upright);
      const Contact b = intersect(ray, tilted);
      if (std::isfinite(a.range_m) != std::isfinite(b.range_m)) {
        // Only a ray that grazes an edge may be judged differently.
        const Contact& hit = std::isfinite(a.range_m) ? a : b;
        CHECK(std::fabs(oracle::depth(upright, ray.origin_m + hit.range_m * ray.direction)) < 1e-9);
        continue;
      }
      if (!std::isfinite(a.range_m)) continue;
      CHECK(a.range_m == Approx(b.range_m).margin(1e-9));
      double x = 0, y = 0, x2 = 0, y2 = 0;
      half_extents(upright, x, y);
      half_extents(tilted, x2, y2);
      CHECK(x2 == Approx(x).margin(1e-9));
      CHECK(y2 == Approx(y).margin(1e-9));
      CHECK(tilted.top_m == Approx(upright.top_m).margin(1e-9));
    }
  }
}

TEST_CASE("a ray into a tilted solid enters where it becomes part of it, and not before") {
  const bool round = GENERATE(false, true);
  Random random(7, round ? 2 : 1);
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Solid solid = random_tilted(random, round);
    const Vec3 middle{solid.center_x_m, solid.center_y_m, 0.5 * (solid.bottom_m + solid.top_m)};
    const Vec3 origin = middle + random_vector(random, 3.0);
    const Vec3 goal = middle + random_vector(random, 0.7);
    const Vec3 way = goal - origin;
    if (norm(way) < 0.1 || contains(solid, origin)) continue;
    const Ray ray{origin, (1.0 / norm(way)) * way};
    const Contact contact = intersect(ray, solid);
    const double reach = std::isfinite(contact.range_m) ? contact.range_m : 8.0;
    double first = -1;
    for (double t = 0; t < reach - 1e-9 && first < 0; t += 0.01) {
      if (contains(solid, origin + t * ray.direction)) first = t;
    }
    REQUIRE(first == -1);
    if (!std::isfinite(contact.range_m)) continue;
    ++hits;
    const Vec3 p = origin + contact.range_m * ray.direction;
    REQUIRE(norm(contact.normal) == Approx(1).epsilon(1e-12));
    REQUIRE(dot(contact.normal, ray.direction) < 0.0);
    REQUIRE_FALSE(contains(solid, p + 1e-9 * contact.normal));
    // The normal leads into the solid unless the point is at an edge, where it leads past it.
    int inside = 0;
    for (const double depth : {1e-9, 1e-7, 1e-5})
      inside += contains(solid, p - depth * contact.normal) ? 1 : 0;
    REQUIRE(inside >= 1);
  }
  CHECK(hits > 800);
}

TEST_CASE("the broad phase changes no bit where solids are tilted") {
  Random random(11, 4);
  World world;
  for (int i = 0; i < 60; ++i) REQUIRE(world.add(random_tilted(random, i % 2 == 0)) == Status::ok);
  REQUIRE(world.finalize() == Status::ok);
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 origin = random_vector(random, 5.0) + Vec3{0, 0, 2.5};
    const Vec3 d = random_unit(random);
    const Hit fast = world.cast(origin, d, 12.0);
    const Hit slow = world.cast_brute_force(origin, d, 12.0);
    REQUIRE(fast.range_m == slow.range_m);
    REQUIRE(fast.solid == slow.solid);
    hits += fast.solid >= 0 ? 1 : 0;
  }
  CHECK(hits > 300);
}

TEST_CASE("rays see the solids that a plant stands on") {
  PlantScene scene;
  REQUIRE(add_stairs(scene, {{1, 0, 0}, 0.4}, {}) == Status::ok);
  REQUIRE(add_pallet(scene, {{0, 2, 0}, -0.3}) == Status::ok);
  REQUIRE(add_rubble(scene, {{-3, 0, 0}, 0}, 2, 2, 40, 5) == Status::ok);
  REQUIRE(scene.add_cylinder({-1, -2, 0.1}, from_yaw_pitch_roll(0.3, 0, 0), 0.1, 0.6) == Status::ok);
  World world;
  REQUIRE(add_to_world(scene, world) == Status::ok);
  REQUIRE(world.size() == scene.solids().size());
  Random random(5, 5);
  for (std::uint32_t i = 0; i < scene.solids().size(); ++i) {
    const rt::convex::Convex& body = scene.solids()[i].shape;
    const rt::convex::Bounds& bounds = scene.solids()[i].bounds;
    const Solid& solid = world.solid(i);
    CHECK(solid.center_x_m - solid.half_x_m == Approx(bounds.low_m.x).margin(1e-9));
    CHECK(solid.center_y_m + solid.half_y_m == Approx(bounds.high_m.y).margin(1e-9));
    CHECK(solid.top_m == Approx(bounds.high_m.z).margin(1e-9));
    for (int k = 0; k < 50; ++k) {
      // In the body's own frame, where what is inside can be read off.
      const Vec3 v = random_vector(random, 1.0);
      const bool round = body.kind == rt::convex::Kind::track;
      const rt::Vector3 size =
          round ? rt::Vector3{body.radius_m[0], body.half_m.y, body.radius_m[0]} : body.half_m;
      const rt::Vector3 local{1.3 * v.x * size.x, 1.3 * v.y * size.y, 1.3 * v.z * size.z};
      const bool within =
          round ? std::hypot(local.x, local.z) <= size.x && std::fabs(local.y) <= size.y
                : std::fabs(v.x) <= 1 / 1.3 && std::fabs(v.y) <= 1 / 1.3 && std::fabs(v.z) <= 1 / 1.3;
      const rt::Vector3 p = body.R_world_body * local + body.p_world_m;
      REQUIRE(contains(solid, {p.x, p.y, p.z}) == within);
    }
  }
}

TEST_CASE("a tilted solid without extent or with a broken frame is refused") {
  World world;
  CHECK(world.add(make_tilted_box({0, 0, 1}, {}, {0.1, 0.0, 0.1})) == Status::out_of_range);
  CHECK(world.add(make_tilted_cylinder({0, 0, 1}, {}, -0.1, 0.1)) == Status::out_of_range);
  CHECK(world.add(make_tilted_box({0, 0, std::nan("")}, {}, {0.1, 0.1, 0.1})) == Status::not_finite);
  Axes broken;
  broken.z.y = std::nan("");
  CHECK(world.add(make_tilted_box({0, 0, 1}, broken, {0.1, 0.1, 0.1})) == Status::not_finite);
  CHECK(world.size() == 0);
}
