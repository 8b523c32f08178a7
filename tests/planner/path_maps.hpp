// SPDX-License-Identifier: BSD-3-Clause
// Many small maps: loose blocks, mazes of single gaps, walls with one hole of one free voxel; and what every
// plan through them must keep.
#pragma once

#include <catch2/catch.hpp>

#include "tests/planner/path_rig.hpp"

namespace sortie::planner::test {

inline constexpr std::int32_t kMapX = 48;
inline constexpr std::int32_t kMapY = 36;
inline constexpr std::int32_t kMapZ = 12;

/// Cells of six voxels behind walls of one, most of them joined by doors of one free voxel; `doors` of 100
/// walls get one, so that there is a way at some shares and none at others.
inline void build_maze(FlightMap& map, std::mt19937& random, std::uint32_t doors) {
  for (std::int32_t z = 0; z < kMapZ; ++z) {
    for (std::int32_t y = 0; y < kMapY; ++y)
      for (std::int32_t x = 0; x < kMapX; ++x)
        if (x % 6 == 0 || y % 6 == 0) static_cast<void>(map.set_blocked({x, y, z}, true));
  }
  // A door: a hole of three voxels across and in height through a wall of one.
  for (std::int32_t y = 0; y < kMapY; y += 6) {
    for (std::int32_t x = 0; x < kMapX; x += 6) {
      for (const bool along_x : {true, false}) {
        const auto chance = static_cast<std::uint32_t>(random() % 100);
        const std::int32_t z = 2 + static_cast<std::int32_t>(random() % (kMapZ - 6));
        const std::int32_t off = 2 + static_cast<std::int32_t>(random() % 2);
        if (chance >= doors || (along_x ? x : y) == 0) continue;
        for (std::int32_t k = 0; k < 9; ++k) {
          const Voxel3 v =
              along_x ? Voxel3{x, y + off + k % 3, z + k / 3} : Voxel3{x + off + k % 3, y, z + k / 3};
          static_cast<void>(map.set_blocked(v, false));
        }
      }
    }
  }
}

/// Walls across x, each with one hole of one free voxel somewhere, and loose blocks between; now and then a
/// wall without a hole.
inline void build_holes(FlightMap& map, std::mt19937& random) {
  for (int i = 0; i < 60; ++i) {
    const auto draw = [&random](std::int32_t n) {
      return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(n));
    };
    const std::int32_t x = draw(kMapX);
    const std::int32_t y = draw(kMapY);
    const std::int32_t z = draw(kMapZ);
    if (x % 8 >= 3 && x % 8 <= 5) static_cast<void>(map.set_blocked({x, y, z}, true));
  }
  for (std::int32_t x = 8; x + 4 < kMapX; x += 8) {
    const std::int32_t hy = 1 + static_cast<std::int32_t>(random() % (kMapY - 4));
    const std::int32_t hz = 1 + static_cast<std::int32_t>(random() % (kMapZ - 4));
    const bool closed = random() % 16 == 0;
    for (std::int32_t z = 0; z < kMapZ; ++z) {
      for (std::int32_t y = 0; y < kMapY; ++y) {
        const bool hole = y >= hy && y < hy + 3 && z >= hz && z < hz + 3;
        if (closed || !hole) static_cast<void>(map.set_blocked({x, y, z}, true));
      }
    }
  }
}

/// Single voxels, `share` of 100.
inline void build_blocks(FlightMap& map, std::mt19937& random, std::uint32_t share) {
  for (std::int32_t z = 0; z < kMapZ; ++z)
    for (std::int32_t y = 0; y < kMapY; ++y)
      for (std::int32_t x = 0; x < kMapX; ++x)
        if (random() % 100 < share) static_cast<void>(map.set_blocked({x, y, z}, true));
}

/// How many maps of each answer.
struct MapTally {
  int ways{};
  int walls{};
};

/// The n-th map: there is a way exactly where breadth-first search over all voxels finds one; every point of
/// it keeps its distance in closed form, and the exact check agrees with every line.
inline void judge_map(std::uint32_t seed, std::uint32_t n, MapTally& tally) {
  CAPTURE(seed, n);
  std::mt19937 random(seed + n);
  OwnedMap owned(cube(kMapX, kMapY, kMapZ, 0.11, 0.1));
  if (n % 3 == 0) build_maze(owned.map, random, 40 + n % 45);
  if (n % 3 == 1) build_holes(owned.map, random);
  if (n % 3 == 2) build_blocks(owned.map, random, 3 + n % 12);
  owned.map.refresh(UINT32_MAX);
  const Voxel3 start = any_free(owned.map, random, 0, 12);
  const Voxel3 goal = any_free(owned.map, random, 36, kMapX);
  if (start.x < 0 || goal.x < 0) return;
  // Every fourth without room for a fine search.
  OwnedPath memory(owned.map, 8 * kMapX * kMapY * kMapZ / 64, n % 4 == 0 ? 64 : 32768);
  CHECK(memory.bytes() + owned.blocked.size() * 16 <= 4'000'000);
  PathState state = memory.path.begin(owned.map, owned.map.middle_m(start), owned.map.middle_m(goal));
  const std::uint64_t slice = 1 + 997 * (n % 5);
  while (state == PathState::running || state == PathState::found) state = memory.path.step(owned.map, slice);
  const bool reachable = is_reachable(owned.map, start, goal);
  CHECK(state == (reachable ? PathState::done : PathState::none));
  (reachable ? tally.ways : tally.walls) += 1;
  if (!reachable) return;
  CHECK(memory.path.is_whole());
  CHECK(memory.path.work().unsafe == 0);
  const auto way = memory.path.waypoints();
  CHECK(is_still_free(owned.map, way));
  double nearest = HUGE_VAL;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const rt::Vector3 d = way[i] - way[i - 1];
    const int pieces = 1 + static_cast<int>(rt::norm(d) / 0.05);
    for (int k = 0; k <= pieces; ++k)
      nearest =
          std::min(nearest, scaled_distance(owned.map, way[i - 1] + (static_cast<double>(k) / pieces) * d));
  }
  CHECK(nearest > 1.0);
}

}  // namespace sortie::planner::test
