// SPDX-License-Identifier: BSD-3-Clause
// Random maps for the path planner and its twins: breadth-first search over all voxels, and closed-form
// distances.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <vector>

#include "planner/uav_path/uav_path.hpp"

namespace sortie::planner::test {

/// A map that owns its memory.
struct OwnedMap {
  explicit OwnedMap(const FlightMapConfig& config)
      : blocked(FlightMap::bricks_for(config)),
        free(blocked.size()),
        dirty(FlightMap::dirty_words_for(config)),
        map(config, blocked, free, dirty) {}
  std::vector<BrickMask> blocked;
  std::vector<BrickMask> free;
  std::vector<std::uint64_t> dirty;
  FlightMap map;
};

/// A planner that owns its memory.
struct OwnedPath {
  explicit OwnedPath(const FlightMap& map, std::uint32_t nodes = 32768, std::uint32_t table = 32768,
                     std::uint32_t corner_count = 4096)
      : parts(nodes),
        part_heap(nodes),
        brick_nodes(map.free_bricks().size()),
        voxels(table),
        voxel_heap(table),
        targets(nodes),
        lengths(nodes),
        points(corner_count),
        sums(corner_count),
        before(corner_count),
        path({{parts, part_heap, brick_nodes},
              {voxels, voxel_heap, targets, lengths},
              {points, sums, before}}) {}
  std::size_t bytes() const {
    return parts.size() * (sizeof(PathNode) + 4 + sizeof(VoxelPoint) + 4) + brick_nodes.size() * 4 +
           voxels.size() * (sizeof(FineVoxel) + 4) + points.size() * (sizeof(Voxel3) + 8);
  }
  std::vector<PathNode> parts;
  std::vector<std::uint32_t> part_heap;
  std::vector<std::uint32_t> brick_nodes;
  std::vector<FineVoxel> voxels;
  std::vector<std::uint32_t> voxel_heap;
  std::vector<VoxelPoint> targets;
  std::vector<float> lengths;
  std::vector<Voxel3> points;
  std::vector<float> sums;
  std::vector<std::uint32_t> before;
  UavPath path;
};

inline FlightMapConfig cube(std::int32_t nx, std::int32_t ny, std::int32_t nz, double radius_m,
                            double height_m) {
  FlightMapConfig config;
  config.nx = nx;
  config.ny = ny;
  config.nz = nz;
  config.voxel_m = 0.2;
  config.origin_m = {-3.0, 1.0, -0.4};
  config.radii_m = {radius_m, radius_m, height_m};
  config.unknown_is_blocked = false;
  return config;
}

/// Walls across x with windows, and pillars, as in a hall with doors. Returns nothing: everything is in the
/// map.
inline void build_hall(FlightMap& map, std::uint32_t seed, int walls, int pillars) {
  std::mt19937 random(seed);
  const auto draw = [&random](std::int32_t n) {
    return static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(n));
  };
  const FlightMapConfig& c = map.config();
  const auto fill = [&](Voxel3 low, Voxel3 high, bool blocked) {
    for (std::int32_t z = std::max(low.z, 0); z < std::min(high.z, c.nz); ++z)
      for (std::int32_t y = std::max(low.y, 0); y < std::min(high.y, c.ny); ++y)
        for (std::int32_t x = std::max(low.x, 0); x < std::min(high.x, c.nx); ++x)
          static_cast<void>(map.set_blocked({x, y, z}, blocked));
  };
  for (int w = 1; w <= walls; ++w) {
    const std::int32_t x = w * c.nx / (walls + 1);
    fill({x, 0, 0}, {x + 1, c.ny, c.nz}, true);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t y = draw(std::max(c.ny - 12, 1));
      const std::int32_t z = k == 0 ? 0 : draw(std::max(c.nz - 10, 1));
      fill({x, y, z}, {x + 1, y + 10, z + 10}, false);
    }
  }
  for (int p = 0; p < pillars; ++p) {
    const std::int32_t x = draw(c.nx - 3);
    const std::int32_t y = draw(c.ny - 3);
    const std::int32_t high = c.nz / 3 + draw(c.nz);
    if (x % (c.nx / (walls + 1)) < 8) continue;
    fill({x, y, 0}, {x + 3, y + 3, high}, true);
  }
  map.refresh(UINT32_MAX);
}

/// A line judged at once, whatever it costs.
inline SweptCheck check_swept(const FlightMap& map, const rt::Vector3& a_m, const rt::Vector3& b_m) {
  SweptWalk walk;
  walk.begin(a_m, b_m);
  std::uint64_t steps = UINT64_MAX;
  static_cast<void>(walk.run(map, steps));  // so much ends every line
  return walk.result();
}

/// True when a way is safe in a map: exact.
inline bool is_still_free(const FlightMap& map, std::span<const rt::Vector3> waypoints) {
  WayWalk walk;
  std::uint64_t steps = UINT64_MAX;
  static_cast<void>(walk.run(map, waypoints, steps));  // so much ends every way
  return walk.is_free();
}

/// A free voxel in the given range of x.
inline Voxel3 any_free(const FlightMap& map, std::mt19937& random, std::int32_t low_x, std::int32_t high_x) {
  const FlightMapConfig& c = map.config();
  for (int i = 0; i < 100000; ++i) {
    const Voxel3 v{low_x + static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(high_x - low_x)),
                   static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(c.ny)),
                   static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(c.nz))};
    if (map.is_free(v)) return v;
  }
  return {-1, -1, -1};
}

/// Breadth first over all 26 neighbours: is there any way?
inline bool is_reachable(const FlightMap& map, const Voxel3& start, const Voxel3& goal) {
  const FlightMapConfig& c = map.config();
  const auto number = [&c](const Voxel3& v) {
    return static_cast<std::size_t>(v.x + c.nx * (v.y + c.ny * v.z));
  };
  std::vector<bool> seen(static_cast<std::size_t>(c.nx) * static_cast<std::size_t>(c.ny) *
                         static_cast<std::size_t>(c.nz));
  std::deque<Voxel3> queue{start};
  seen[number(start)] = true;
  while (!queue.empty()) {
    const Voxel3 v = queue.front();
    queue.pop_front();
    if (v == goal) return true;
    for (int i = 0; i < 27; ++i) {
      const Voxel3 n{v.x + i % 3 - 1, v.y + i / 3 % 3 - 1, v.z + i / 9 - 1};
      if (!map.is_free(n) || seen[number(n)]) continue;
      seen[number(n)] = true;
      queue.push_back(n);
    }
  }
  return false;
}

/// How far the ellipsoid at a point stays from the nearest blocked voxel, in the space in which it is a ball
/// of radius one: above 1 it touches nothing. Closed form: a box stays a box when the axes are scaled.
inline double scaled_distance(const FlightMap& map, const rt::Vector3& p) {
  const FlightMapConfig& c = map.config();
  const Voxel3 v = map.voxel_at(p);
  double nearest = HUGE_VAL;
  for (std::int32_t z = v.z - 5; z <= v.z + 5; ++z) {
    for (std::int32_t y = v.y - 5; y <= v.y + 5; ++y) {
      for (std::int32_t x = v.x - 5; x <= v.x + 5; ++x) {
        if (!map.is_blocked({x, y, z})) continue;
        const rt::Vector3 d = map.middle_m({x, y, z}) - p;
        const auto gap = [&c](double distance, double radius) {
          return std::max(std::abs(distance) - 0.5 * c.voxel_m, 0.0) / radius;
        };
        nearest = std::min(nearest,
                           rt::norm({gap(d.x, c.radii_m.x), gap(d.y, c.radii_m.y), gap(d.z, c.radii_m.z)}));
      }
    }
  }
  return nearest;
}

}  // namespace sortie::planner::test
