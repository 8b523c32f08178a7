// SPDX-License-Identifier: BSD-3-Clause
// Straight lines: of sight, and of the exact check.
#include <catch2/catch.hpp>

#include "planner/uav_path/sight.hpp"
#include "planner/uav_path/swept_check.hpp"
#include "rt/convex/query.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {
namespace {

// The twin judges every blocked voxel of the map, wherever it is.
bool touches_nothing(const FlightMap& map, const rt::Vector3& a, const rt::Vector3& b) {
  const FlightMapConfig& c = map.config();
  rt::convex::Convex robot = rt::convex::make_swept_ellipsoid(c.radii_m, 0.5 * (b - a));
  robot.p_world_m = 0.5 * (a + b);
  const double half = 0.5 * c.voxel_m;
  rt::convex::Convex voxel = rt::convex::make_box({half, half, half});
  for (std::int32_t n = 0; n < c.nx * c.ny * c.nz; ++n) {
    const Voxel3 v{n % c.nx, n / c.nx % c.ny, n / (c.nx * c.ny)};
    if (!map.is_blocked(v)) continue;
    voxel.p_world_m = map.middle_m(v);
    if (rt::convex::is_collision(rt::convex::query(robot, voxel).state)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("uav path: lines of sight agree with a fine walk along the line, both ways") {
  const std::uint32_t seed = 21;
  CAPTURE(seed);
  OwnedMap owned(cube(32, 32, 24, 0.11, 0.1));
  std::mt19937 random(seed);
  for (int i = 0; i < 300; ++i)
    static_cast<void>(owned.map.set_blocked(
        {static_cast<std::int32_t>(random() % 32), static_cast<std::int32_t>(random() % 32),
         static_cast<std::int32_t>(random() % 24)},
        true));
  owned.map.refresh(UINT32_MAX);
  int clear = 0;
  for (int i = 0; i < 2000; ++i) {
    const Voxel3 a = any_free(owned.map, random, 0, 32);
    const Voxel3 b = any_free(owned.map, random, 0, 32);
    bool walked = true;
    for (int k = 0; k <= 4000 && walked; ++k) {
      const rt::Vector3 from = owned.map.middle_m(a);
      const rt::Vector3 p = from + (k / 4000.0) * (owned.map.middle_m(b) - from);
      // Where the line crosses an edge or a corner, rounding would put the point into any of the voxels
      // there.
      const auto on_border = [](double value, double origin) {
        const double voxels = (value - origin) / 0.2;
        return std::abs(voxels - std::round(voxels)) < 1e-7;
      };
      const rt::Vector3& o = owned.map.config().origin_m;
      if (on_border(p.x, o.x) || on_border(p.y, o.y) || on_border(p.z, o.z)) continue;
      walked = owned.map.is_free(owned.map.voxel_at(p));
    }
    const bool seen = line_is_free(owned.map, a, b);
    CHECK(seen == line_is_free(owned.map, b, a));
    if (!walked) CHECK_FALSE(seen);  // the walk may miss a corner that the line cuts by less than its step
    clear += seen ? 1 : 0;
    if (seen) CHECK(check_swept(owned.map, owned.map.middle_m(a), owned.map.middle_m(b)).is_free);
  }
  CHECK(clear > 200);
}

TEST_CASE("uav path: the exact check misses no voxel of the map, whatever way the line goes") {
  const std::uint32_t seed = 31;
  CAPTURE(seed);
  OwnedMap owned(cube(32, 24, 20, 0.3, 0.15));
  std::mt19937 random(seed);
  const auto draw = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  for (int i = 0; i < 60; ++i) {
    const auto x = static_cast<std::int32_t>(random() % 32);
    const auto y = static_cast<std::int32_t>(random() % 24);
    const auto z = static_cast<std::int32_t>(random() % 20);
    static_cast<void>(owned.map.set_blocked({x, y, z}, true));
  }
  for (std::int32_t n = 0; n < 64; ++n)  // a whole brick
    static_cast<void>(owned.map.set_blocked({12 + n % 4, 8 + n / 4 % 4, 8 + n / 16}, true));
  owned.map.refresh(UINT32_MAX);
  const rt::Vector3 low = owned.map.config().origin_m + rt::Vector3{0.31, 0.31, 0.16};
  const rt::Vector3 high = owned.map.config().origin_m + rt::Vector3{6.4 - 0.31, 4.8 - 0.31, 4.0 - 0.16};
  int clear = 0;
  for (int i = 0; i < 3000; ++i) {
    rt::Vector3 a;
    a.x = draw(low.x, high.x);
    a.y = draw(low.y, high.y);
    a.z = draw(low.z, high.z);
    rt::Vector3 b = a;
    // Along an axis, in a plane, or any way; short or long; now and then no way at all.
    const auto axes = static_cast<std::uint32_t>(random() % 8);
    const double share = i % 2 == 0 ? 1.0 : 0.2;
    if ((axes & 1u) != 0) b.x += share * (draw(low.x, high.x) - a.x);
    if ((axes & 2u) != 0) b.y += share * (draw(low.y, high.y) - a.y);
    if ((axes & 4u) != 0) b.z += share * (draw(low.z, high.z) - a.z);
    const bool free = check_swept(owned.map, a, b).is_free;
    if (free != touches_nothing(owned.map, a, b)) FAIL_CHECK("line " << i);
    clear += free ? 1 : 0;
  }
  CHECK(clear > 300);
  CHECK(clear < 2700);
}

TEST_CASE("uav path: the exact check looks at bricks along the line, not at the box around it") {
  OwnedMap owned(cube(256, 256, 64, 0.35, 0.15));
  owned.map.refresh(UINT32_MAX);
  const FlightMap& map = owned.map;
  const Voxel3 ends[][2] = {{{4, 4, 4}, {251, 251, 59}},
                            {{4, 251, 30}, {251, 4, 30}},
                            {{4, 4, 4}, {4, 4, 59}},
                            {{4, 128, 32}, {251, 129, 33}}};
  for (const auto& [a, b] : ends) {
    const SweptCheck check = check_swept(map, map.middle_m(a), map.middle_m(b));
    CHECK(check.is_free);
    // Bricks that the line passes, and those beside them that the robot's radius may reach into.
    const std::int32_t passed = std::abs(a.x - b.x) / 4 + std::abs(a.y - b.y) / 4 + std::abs(a.z - b.z) / 4;
    CHECK(check.bricks <= 8 * static_cast<std::uint32_t>(passed + 4));
  }
}

}  // namespace sortie::planner::test
