// SPDX-License-Identifier: BSD-3-Clause
// Ways through maps: there is one whenever there can be one, it touches nothing, and it does not depend on
// slices.
#include "planner/uav_path/uav_path.hpp"

#include <catch2/catch.hpp>

#include "rt/posix/heap_trap.hpp"
#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {
namespace {

PathState plan(UavPath& path, const FlightMap& map, const Voxel3& start, const Voxel3& goal,
               std::uint64_t slice) {
  PathState state = path.begin(map, map.middle_m(start), map.middle_m(goal));
  for (int i = 0; i < 10'000'000 && (state == PathState::running || state == PathState::found); ++i)
    state = path.step(map, slice);
  return state;
}

// The way starts and ends where it should and the robot touches nothing: by points 2 cm apart, in closed
// form.
void check_way(const FlightMap& map, const UavPath& path, const Voxel3& start, const Voxel3& goal) {
  const auto way = path.waypoints();
  REQUIRE(way.size() >= 1);
  CHECK(rt::norm(way.front() - map.middle_m(start)) < 1e-9);
  if (path.is_whole()) CHECK(rt::norm(way.back() - map.middle_m(goal)) < 1e-9);
  double nearest = HUGE_VAL;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const rt::Vector3 d = way[i] - way[i - 1];
    const int pieces = 1 + static_cast<int>(rt::norm(d) / 0.02);
    for (int k = 0; k <= pieces; ++k)
      nearest = std::min(nearest, scaled_distance(map, way[i - 1] + (static_cast<double>(k) / pieces) * d));
  }
  CHECK(nearest > 1.0);
  CHECK(path.work().unsafe == 0);
}

}  // namespace

TEST_CASE(
    "uav path: in 150 random maps there is a way whenever breadth-first search finds one, and it is safe") {
  const std::uint32_t seed = 1000;
  CAPTURE(seed);
  int ways = 0;
  int walls = 0;
  for (std::uint32_t n = 0; n < 150; ++n) {
    CAPTURE(n);
    std::mt19937 random(seed + n);
    OwnedMap owned(cube(36, 32, 16, 0.11, 0.1));
    // Thinner than a voxel's margin: single gaps between random blocks stay open now and then.
    const std::uint32_t share = 3 + n % 12;
    for (std::int32_t z = 0; z < 16; ++z)
      for (std::int32_t y = 0; y < 32; ++y)
        for (std::int32_t x = 0; x < 36; ++x)
          if (random() % 100 < share) static_cast<void>(owned.map.set_blocked({x, y, z}, true));
    owned.map.refresh(UINT32_MAX);
    const Voxel3 start = any_free(owned.map, random, 0, 10);
    const Voxel3 goal = any_free(owned.map, random, 26, 36);
    if (start.x < 0 || goal.x < 0) continue;
    OwnedPath memory(owned.map, 8 * 36 * 32 * 16 / 64,
                     n % 2 == 0 ? 32768 : 64);  // half of them without a fine search
    const PathState state = plan(memory.path, owned.map, start, goal, 500);
    const bool reachable = is_reachable(owned.map, start, goal);
    CHECK(state == (reachable ? PathState::done : PathState::none));
    (reachable ? ways : walls) += 1;
    if (reachable) check_way(owned.map, memory.path, start, goal);
  }
  CHECK(ways > 30);
  CHECK(walls > 10);
}

TEST_CASE("uav path: a maze of single gaps is solved, with and without room for a fine search") {
  const std::uint32_t seed = 77;
  CAPTURE(seed);
  std::mt19937 random(seed);
  OwnedMap owned(cube(60, 60, 12, 0.11, 0.1));
  // Cells of six voxels behind walls of one; a random spanning tree of doors of three voxels: one free voxel
  // each.
  const std::int32_t cells = 10;
  for (std::int32_t z = 0; z < 12; ++z)
    for (std::int32_t i = 0; i < 60; ++i)
      for (std::int32_t w = 6; w < 60; w += 6) {
        static_cast<void>(owned.map.set_blocked({w, i, z}, true));
        static_cast<void>(owned.map.set_blocked({i, w, z}, true));
      }
  std::vector<bool> seen(100);
  std::vector<std::int32_t> stack{0};
  seen[0] = true;
  while (!stack.empty()) {
    const std::int32_t cell = stack.back();
    std::vector<std::int32_t> near;
    for (const std::int32_t step : {-1, 1, -cells, cells}) {
      const std::int32_t next = cell + step;
      if (next < 0 || next >= 100 || seen[static_cast<std::size_t>(next)]) continue;
      if ((step == -1 && cell % cells == 0) || (step == 1 && cell % cells == cells - 1)) continue;
      near.push_back(next);
    }
    if (near.empty()) {
      stack.pop_back();
      continue;
    }
    const std::int32_t next = near[random() % near.size()];
    seen[static_cast<std::size_t>(next)] = true;
    stack.push_back(next);
    const std::int32_t x = 3 * (cell % cells + next % cells) + 3;
    const std::int32_t y = 3 * (cell / cells + next / cells) + 3;
    for (std::int32_t k = -1; k <= 1; ++k)
      for (std::int32_t z = 4; z < 7; ++z)
        static_cast<void>(owned.map.set_blocked(
            next % cells == cell % cells ? Voxel3{x + k, y, z} : Voxel3{x, y + k, z}, false));
  }
  owned.map.refresh(UINT32_MAX);
  const Voxel3 start{3, 3, 5};
  const Voxel3 goal{57, 57, 8};
  REQUIRE(is_reachable(owned.map, start, goal));
  double lengths[2]{};
  for (int k = 0; k < 2; ++k) {
    OwnedPath memory(owned.map, 32768, k == 0 ? 32768 : 64);
    REQUIRE(plan(memory.path, owned.map, start, goal, 1000) == PathState::done);
    check_way(owned.map, memory.path, start, goal);
    CHECK(memory.path.work().crawled == static_cast<std::uint32_t>(k));
    lengths[k] = memory.path.length_m();
  }
  CHECK(lengths[1] < 1.1 * lengths[0]);
}

TEST_CASE("uav path: the way does not depend on the slices, and there is no heap call") {
  OwnedMap owned(cube(100, 80, 24, 0.3, 0.2));
  build_hall(owned.map, 9, 3, 40);
  std::mt19937 random(9);
  const Voxel3 start = any_free(owned.map, random, 0, 20);
  const Voxel3 goal = any_free(owned.map, random, 80, 100);
  REQUIRE(is_reachable(owned.map, start, goal));
  OwnedPath whole(owned.map);
  REQUIRE(plan(whole.path, owned.map, start, goal, UINT64_MAX / 32) == PathState::done);
  for (const std::uint64_t slice : {1u, 7u, 100u, 3000u}) {
    OwnedPath sliced(owned.map);
    std::uint64_t calls = 0;
    {
      const rt::posix::HeapTrapScope scope;
      static_cast<void>(plan(sliced.path, owned.map, start, goal, slice));
      calls = scope.calls();
    }
    if (rt::posix::kHeapTrapAvailable) CHECK(calls == 0);
    REQUIRE(sliced.path.waypoints().size() == whole.path.waypoints().size());
    for (std::size_t i = 0; i < whole.path.waypoints().size(); ++i)
      CHECK(rt::norm(sliced.path.waypoints()[i] - whole.path.waypoints()[i]) == 0.0);
  }
}

TEST_CASE("uav path: all the units there are shorten a way to its end") {
  OwnedMap owned(cube(100, 80, 24, 0.3, 0.2));
  build_hall(owned.map, 9, 3, 40);
  std::mt19937 random(9);
  const Voxel3 start = any_free(owned.map, random, 0, 20);
  const Voxel3 goal = any_free(owned.map, random, 80, 100);
  for (const std::uint64_t rest : {std::uint64_t{1} << 60, UINT64_MAX}) {
    OwnedPath memory(owned.map);
    PathState state = memory.path.begin(owned.map, owned.map.middle_m(start), owned.map.middle_m(goal));
    while (state == PathState::running) state = memory.path.step(owned.map, 1);
    REQUIRE(state == PathState::found);
    CHECK(memory.path.step(owned.map, rest) == PathState::done);
  }
}

TEST_CASE("uav path: from the first way on it only gets shorter, and each of them is safe") {
  OwnedMap owned(cube(100, 80, 24, 0.3, 0.2));
  build_hall(owned.map, 12, 3, 60);
  std::mt19937 random(12);
  const Voxel3 start = any_free(owned.map, random, 0, 20);
  const Voxel3 goal = any_free(owned.map, random, 80, 100);
  OwnedPath memory(owned.map);
  PathState state = memory.path.begin(owned.map, owned.map.middle_m(start), owned.map.middle_m(goal));
  double before = HUGE_VAL;
  int seen = 0;
  while (state == PathState::running || state == PathState::found) {
    state = memory.path.step(owned.map, 50);
    if (state == PathState::running) CHECK(memory.path.waypoints().empty());
    if (memory.path.waypoints().empty() || !memory.path.is_whole()) continue;
    const double now = memory.path.length_m();
    CHECK(now <= before + 1e-9);
    if (now < before) {
      ++seen;
      check_way(owned.map, memory.path, start, goal);
    }
    before = now;
  }
  CHECK(state == PathState::done);
  CHECK(seen >= 2);
}

TEST_CASE("uav path: bad questions, a map that changes, and a way that is cut") {
  OwnedMap owned(cube(60, 40, 16, 0.3, 0.2));
  build_hall(owned.map, 30, 1, 0);
  OwnedPath memory(owned.map);
  UavPath& path = memory.path;
  const FlightMap& map = owned.map;
  CHECK(path.step(map, 10) == PathState::idle);
  const rt::Vector3 inside = map.middle_m({5, 20, 8});
  const rt::Vector3 beyond = map.middle_m({55, 20, 8});
  CHECK(path.begin(map, {std::nan(""), 0, 0}, beyond) == PathState::bad_start);
  CHECK(path.begin(map, {1e9, 0, 0}, beyond) == PathState::running);  // looked for in step()
  CHECK(path.step(map, 100) == PathState::bad_start);
  CHECK(path.begin(map, inside, map.middle_m({30, 39, 15})) == PathState::bad_goal);
  CHECK(path.begin(map, inside, {0, std::nan(""), 0}) == PathState::bad_goal);
  // Beside the map's border no voxel is free, but the robot can come out by itself.
  const rt::Vector3 tight = map.middle_m({2, 20, 8}) - rt::Vector3{0.15, 0, 0};
  REQUIRE_FALSE(map.is_free(map.voxel_at(tight)));
  PathState state = path.begin(map, tight, beyond);
  while (state == PathState::running || state == PathState::found) state = path.step(map, 1000);
  REQUIRE(state == PathState::done);
  CHECK(rt::norm(path.waypoints().front() - tight) == 0.0);
  CHECK(is_still_free(map, path.waypoints()));
  // A wall grows across the way.
  const std::vector<rt::Vector3> old(path.waypoints().begin(), path.waypoints().end());
  CHECK(path.begin(map, inside, beyond) == PathState::running);
  CHECK(path.step(map, 20) == PathState::running);
  for (std::int32_t y = 0; y < 40; ++y)
    for (std::int32_t z = 0; z < 16; ++z) static_cast<void>(owned.map.set_blocked({45, y, z}, true));
  owned.map.refresh(UINT32_MAX);
  CHECK(path.step(map, 20) == PathState::outdated);
  CHECK_FALSE(is_still_free(map, old));
  CHECK(plan(path, map, {10, 20, 8}, {55, 20, 8}, 1000) == PathState::none);
  // Too little memory says so.
  OwnedPath small(map, 8);
  CHECK(plan(small.path, map, {10, 20, 8}, {25, 20, 8}, 1000) == PathState::capacity);
  // A map that cannot be has no free voxel.
  FlightMapConfig odd = cube(30, 40, 16, 0.3, 0.2);
  CHECK(OwnedMap(odd).map.usable() == Status::out_of_range);
  odd = cube(32, 40, 16, 3.0, 0.2);
  CHECK(OwnedMap(odd).map.usable() == Status::out_of_range);
}

}  // namespace sortie::planner::test
