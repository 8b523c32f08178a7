// SPDX-License-Identifier: BSD-3-Clause
// The exact checks of ways, in slices: nothing comes on top of the units, and the answer is that of a check
// at once.
#include <catch2/catch.hpp>

#include "planner/uav_guide.hpp"
#include "planner/uav_path/swept_check.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {
namespace {

// Many loose blocks: the exact check has pairs to judge all along a way.
void build_blocks(FlightMap& map, std::mt19937& random, int blocks) {
  const FlightMapConfig& c = map.config();
  const auto draw = [&random](std::int32_t n) {
    return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(n));
  };
  for (int i = 0; i < blocks; ++i)
    static_cast<void>(map.set_blocked({draw(c.nx), draw(c.ny), draw(c.nz)}, true));
  map.refresh(UINT32_MAX);
}

rt::Vector3 any_point(const FlightMap& map, std::mt19937& random) {
  const FlightMapConfig& c = map.config();
  const auto draw = [&](double radius, std::int32_t n) {
    return radius + (n * c.voxel_m - 2 * radius) * (static_cast<double>(random()) / 4294967296.0);
  };
  const double x = draw(c.radii_m.x, c.nx);
  const double y = draw(c.radii_m.y, c.ny);
  const double z = draw(c.radii_m.z, c.nz);
  return c.origin_m + rt::Vector3{x, y, z};
}

}  // namespace

TEST_CASE("uav path: an exact check in slices says and looks at what one at once does, and keeps its steps") {
  const std::uint32_t seed = 41;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap owned(cube(64, 48, 24, 0.3, 0.15));
  build_blocks(owned.map, random, 500);
  int clear = 0;
  std::uint64_t sliced = 0;
  for (int i = 0; i < 2000; ++i) {
    const rt::Vector3 a = any_point(owned.map, random);
    const rt::Vector3 b =
        i % 3 == 0 ? any_point(owned.map, random) : a + 0.1 * (any_point(owned.map, random) - a);
    const SweptCheck whole = check_swept(owned.map, a, b);
    SweptWalk walk;
    walk.begin(a, b);
    const std::uint64_t slice = 1 + random() % 40;
    bool ended = false;
    std::uint32_t queries = 0;
    for (std::uint32_t bricks = 0; !ended; ++sliced) {
      std::uint64_t steps = slice;
      ended = walk.run(owned.map, steps);
      const std::uint64_t used =
          (walk.result().queries - queries) * SweptWalk::kPair + walk.result().bricks - bricks;
      REQUIRE(used <= slice + SweptWalk::kMostPastEnd);
      REQUIRE((ended || walk.result().bricks > bricks));
      queries = walk.result().queries;
      bricks = walk.result().bricks;
    }
    CHECK(walk.result().is_free == whole.is_free);
    CHECK(walk.result().queries == whole.queries);
    CHECK(walk.result().bricks == whole.bricks);
    clear += whole.is_free ? 1 : 0;
  }
  CHECK(clear > 300);
  CHECK(clear < 1900);
  CHECK(sliced > 5000);
}

TEST_CASE("uav path: a whole way in slices is free when each of its lines is") {
  const std::uint32_t seed = 42;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap owned(cube(64, 48, 24, 0.3, 0.15));
  build_blocks(owned.map, random, 150);
  int clear = 0;
  for (int i = 0; i < 500; ++i) {
    std::vector<rt::Vector3> way(random() % 6);
    for (rt::Vector3& point : way)
      point = &point == way.data() ? any_point(owned.map, random)
                                   : (&point)[-1] + 0.15 * (any_point(owned.map, random) - (&point)[-1]);
    bool expected = true;
    for (std::size_t k = 1; k < way.size(); ++k)
      expected = expected && check_swept(owned.map, way[k - 1], way[k]).is_free;
    WayWalk walk;
    std::uint64_t steps = 1 + random() % 30;
    while (!walk.run(owned.map, way, steps)) steps = 1 + random() % 30;
    CHECK(walk.is_free() == expected);
    CHECK(is_still_free(owned.map, way) == expected);
    clear += expected ? 1 : 0;
  }
  CHECK(clear > 100);
  CHECK(clear < 450);
}

TEST_CASE("uav path: on a map of 4.2 million cells no slice looks at more than its units and a brick",
          "[heavy]") {
  const std::uint32_t seed = 43;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap owned(cube(256, 256, 64, 0.35, 0.15));
  build_blocks(owned.map, random, 12000);
  const FlightMap& map = owned.map;
  OwnedPath memory(map, 65536, 65536);
  UavPath& path = memory.path;
  const Voxel3 goal = any_free(map, random, 240, 256);
  int leads = 0;
  for (int n = 0; n < 40; ++n) {
    const rt::Vector3 start = any_point(map, random);
    if (start.x > map.middle_m({40, 0, 0}).x) continue;
    leads += map.is_free(map.voxel_at(start)) ? 0 : 1;
    UavPathWork before = path.work();
    PathState state = path.begin(map, start, map.middle_m(goal));
    REQUIRE(path.work().bricks == before.bricks);
    const std::uint64_t slice = 1 + 20 * static_cast<std::uint64_t>(n % 2);
    while (state == PathState::running || state == PathState::found) {
      state = path.step(map, slice);
      REQUIRE(path.work().exact - before.exact <= slice + 64);
      REQUIRE(path.work().bricks - before.bricks <= UavPath::kStepsPerUnit * slice);
      before = path.work();
    }
    CHECK((state == PathState::done || state == PathState::bad_start));
    if (state == PathState::done) CHECK(is_still_free(map, path.waypoints()));
  }
  CHECK(leads >= 2);
  CHECK(path.work().bricks > 5000);
  CHECK(path.work().unsafe == 0);
}

TEST_CASE("uav path: a way that is shown is looked at again in slices when the map changes") {
  // A long way, and a box far beside it that comes up after a second.
  FlightMapConfig config = cube(1024, 32, 16, 0.3, 0.15);
  config.origin_m = {};
  OwnedMap owned(config);
  std::mt19937 random(44);
  build_blocks(owned.map, random, 6000);
  OwnedPath path(owned.map, 65536, 65536);
  const std::vector<KnownBox> boxes = {{{100.0, 0.0, 0.0}, {100.2, 0.4, 0.4}, rt::kNanosecondsPerSecond}};
  UavGuide guide(owned.map, path.path, boxes);
  const rt::Vector3 from = owned.map.middle_m(any_free(owned.map, random, 0, 8));
  const rt::Vector3 to = owned.map.middle_m(any_free(owned.map, random, 1016, 1024));
  const WayQuestion question{1, {from.x, from.y, from.z}, {to.x, to.y, to.z}};
  guide.look(&question, 0);
  while (guide.works()) guide.step();
  REQUIRE(guide.way().state == static_cast<std::uint32_t>(PathState::done));
  guide.look(&question, rt::kNanosecondsPerSecond);
  const std::uint32_t version = guide.map().version();
  int checks = 0;
  for (; guide.works(); checks += guide.map().version() != version && guide.works() ? 1 : 0) guide.step();
  CHECK(checks >= 2);
  CHECK(guide.way().blocked == 0);
}

}  // namespace sortie::planner::test
