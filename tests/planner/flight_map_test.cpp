// SPDX-License-Identifier: BSD-3-Clause
// A flight map: which voxels are free, and that it is the same however it came about.
#include "planner/uav_path/flight_map.hpp"

#include <catch2/catch.hpp>

#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {

TEST_CASE("uav path: a voxel is free where the robot can be anywhere in it, by closed form") {
  const std::uint32_t seed = 3;
  CAPTURE(seed);
  OwnedMap owned(cube(32, 32, 24, 0.35, 0.15));
  REQUIRE(owned.map.usable() == Status::ok);
  build_hall(owned.map, seed, 2, 12);
  std::mt19937 random(seed);
  int free = 0;
  int tight = 0;
  for (int i = 0; i < 4000; ++i) {
    const Voxel3 v{static_cast<std::int32_t>(random() % 32), static_cast<std::int32_t>(random() % 32),
                   static_cast<std::int32_t>(random() % 24)};
    const auto jitter = [&random] { return 0.2 * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
    const double jx = jitter();
    const double jy = jitter();
    const double jz = jitter();
    const double there = scaled_distance(owned.map, owned.map.middle_m(v) + rt::Vector3{jx, jy, jz});
    if (owned.map.is_free(v)) {
      ++free;
      CHECK(there > 1.0);
    }
    // And it is not shy: a voxel with a diagonal to spare on all sides is free.
    if (scaled_distance(owned.map, owned.map.middle_m(v)) > 1.0 + 0.19 / 0.15) {
      ++tight;
      CHECK(owned.map.is_free(v));
    }
  }
  CHECK(free > 500);
  CHECK(tight > 200);
}

TEST_CASE("uav path: a map that changes piece by piece equals one that was built at once") {
  const std::uint32_t seed = 4;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap one(cube(24, 20, 16, 0.3, 0.2));
  one.map.refresh(UINT32_MAX);
  for (int round = 0; round < 30; ++round) {
    for (int i = 0; i < 6; ++i) {
      const Voxel3 v{static_cast<std::int32_t>(random() % 24), static_cast<std::int32_t>(random() % 20),
                     static_cast<std::int32_t>(random() % 16)};
      REQUIRE(one.map.set_blocked(v, !one.map.is_blocked(v)) == Status::ok);
    }
    const std::uint32_t version = one.map.version();
    while (!one.map.refresh(3)) {
    }
    CHECK(one.map.version() > version);
    OwnedMap other(cube(24, 20, 16, 0.3, 0.2));
    for (std::int32_t n = 0; n < 24 * 20 * 16; ++n) {
      const Voxel3 v{n % 24, n / 24 % 20, n / 480};
      REQUIRE(other.map.set_blocked(v, one.map.is_blocked(v)) == Status::ok);
    }
    other.map.refresh(UINT32_MAX);
    REQUIRE(one.free == other.free);
  }
}

TEST_CASE(
    "uav path: what changes where nobody fits is a change as well: exact checks ask the blocked voxels") {
  OwnedMap owned(cube(24, 20, 16, 0.3, 0.2));
  for (std::int32_t n = 0; n < 20 * 16; ++n) {
    for (const std::int32_t x : {10, 12}) {  // two walls, a voxel apart
      REQUIRE(owned.map.set_blocked({x, n % 20, n / 20}, true) == Status::ok);
    }
  }
  owned.map.refresh(UINT32_MAX);
  const auto free = owned.free;
  const std::uint32_t version = owned.map.version();
  owned.map.refresh(UINT32_MAX);
  CHECK(owned.map.version() == version);  // nothing to work in
  REQUIRE(owned.map.set_blocked({11, 10, 8}, true) == Status::ok);
  owned.map.refresh(UINT32_MAX);
  CHECK(owned.free == free);
  CHECK(owned.map.version() > version);
}

}  // namespace sortie::planner::test
