// SPDX-License-Identifier: BSD-3-Clause
// Maps for the ray scheduler's tests and benchmark: streets as a robot would have measured them, and the
// nine maps on which planners go wrong. Integers and + - * / only: the same cells on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "mapping/occupancy/occupancy.hpp"
#include "planner/ray_scheduler.hpp"

namespace sortie::tests {

/// A map with its memory.
struct RayMap {
  explicit RayMap(const mapping::OccupancyConfig& config = {})
      : cells(static_cast<std::size_t>(mapping::OccupancyMap::memory_bytes(config))), map(config, cells) {}
  RayMap(const RayMap&) = delete;
  RayMap& operator=(const RayMap&) = delete;

  std::vector<std::int8_t> cells;
  mapping::OccupancyMap map;
};

/// A scheduler with its memory.
struct OwnedScheduler {
  explicit OwnedScheduler(const planner::RaySchedulerConfig& config)
      : memory(static_cast<std::size_t>(planner::RayScheduler::memory_bytes(config))),
        scheduler(config, memory) {}

  std::vector<std::byte> memory;
  planner::RayScheduler scheduler;
};

/// A number from numbers: splitmix64's mixing.
inline std::uint64_t scene_hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
/// In [0, 1).
inline double scene_share(std::uint64_t x) { return static_cast<double>(scene_hash(x) >> 11) * 0x1p-53; }

/// Which cells of a window of `size` are solid: a street along x with walls that have gaps, house fronts at
/// different depths, parked boxes, poles, and ground.
class Street {
 public:
  Street(const std::int32_t (&size)[3], std::uint64_t seed) : seed_(seed) {
    for (int a = 0; a < 3; ++a) size_[a] = size[a];
    ground_ = size[2] / 6;
  }

  bool solid(std::int32_t x, std::int32_t y, std::int32_t z) const {
    if (z <= ground_) return true;
    const std::int32_t middle = size_[1] / 2;
    const bool left = y >= middle;
    const std::int32_t off = left ? y - middle : middle - 1 - y;
    const std::uint64_t house = static_cast<std::uint64_t>(x / 40) * 2 + (left ? 1 : 0);
    const std::int32_t front = 25 + static_cast<std::int32_t>(scene_share(seed_ * 977 + house) * 25);
    const bool gap = scene_share(seed_ * 331 + house + 5000) < 0.2;
    if (!gap && off >= front && off < front + 2)
      return z < size_[2] - static_cast<std::int32_t>(house % 3) * 4;
    if (!gap && off > front && x % 40 == 0) return true;
    const std::uint64_t lot = static_cast<std::uint64_t>(x / 28) * 2 + (left ? 1 : 0);
    const bool car = scene_share(seed_ * 53 + lot + 90000) < 0.5;
    if (car && x % 28 < 20 && off >= 14 && off < 23) return z < ground_ + 8;
    return x % 35 == 3 && off == 24 && z < ground_ + 20;
  }
  std::int32_t ground() const { return ground_; }
  std::uint64_t seed() const { return seed_; }

 private:
  std::int32_t size_[3];
  std::int32_t ground_;
  std::uint64_t seed_;
};

/// Where a ray from `from` (world, m) along a unit vector ends: the first solid cell, or `range_m`.
inline bool cast_ray(const Street& street, const mapping::OccupancyView& view, const rt::Vector3& from,
                     const rt::Vector3& direction, double range_m, rt::Vector3& to) {
  const rt::Vector3 u = view.to_window(from);
  for (double t = 0; t < range_m; t += 0.25 * view.voxel_size_m) {
    const rt::Vector3 p = u + (t / view.voxel_size_m) * direction;
    if (!view.contains(p)) break;
    if (street.solid(static_cast<std::int32_t>(p.x), static_cast<std::int32_t>(p.y),
                     static_cast<std::int32_t>(p.z))) {
      to = from + t * direction;
      return true;
    }
  }
  to = from + range_m * direction;
  return false;
}

/// Unit vector of a ray in the sensor's frame.
inline rt::Vector3 ray_direction(const planner::RaySensor& sensor, std::uint32_t ray) {
  const rt::SinCos azimuth = planner::ray_angle(ray % sensor.columns, sensor.columns, sensor.width_rad);
  const rt::SinCos elevation = planner::ray_angle(ray / sensor.columns, sensor.rows, sensor.height_rad);
  return {elevation.cos * azimuth.cos, elevation.cos * azimuth.sin, elevation.sin};
}

/// A pose in the street `forward_m` from where the window is centred.
inline mapping::SensorPose street_pose(const Street& street, const mapping::OccupancyView& view,
                                       double forward_m) {
  const double low_z = view.voxel_size_m * (view.low[2] + street.ground() + 6);
  const double side = 0.3 * static_cast<double>(street.seed() % 5);
  return {{0.05 + forward_m, 0.07 + side, low_z + 0.03}, {}};
}

/// What `rays` random rays from each of nine past places have shown.
inline void measure_street(RayMap& map, const Street& street, const planner::RaySensor& sensor, int rays) {
  std::mt19937_64 random(street.seed());
  for (int step = 0; step < 9; ++step) {
    const mapping::OccupancyView view = map.map.view();
    const mapping::SensorPose pose = street_pose(street, view, 2.0 * step - 16.0);
    for (int i = 0; i < rays; ++i) {
      const auto ray = static_cast<std::uint32_t>(random() % sensor.rays());
      rt::Vector3 to;
      const bool hit =
          cast_ray(street, view, pose.p_world_sensor_m, ray_direction(sensor, ray), sensor.range_m, to);
      (void)map.map.update_ray(pose.p_world_sensor_m, to, hit);
    }
  }
}

/// Distance of blocks of 4 x 4 x 4 cells to the nearest one with a measurement, in blocks (city block
/// metric).
inline std::vector<int> distance_to_measured(const mapping::OccupancyView& view, std::int32_t (&blocks)[3]) {
  for (int a = 0; a < 3; ++a) blocks[a] = (view.size[a] + 3) / 4;
  const auto at = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
    return static_cast<std::size_t>((z * blocks[1] + y) * blocks[0] + x);
  };
  std::vector<int> distance(at(0, 0, blocks[2]), 1000);
  for (std::int32_t z = 0; z < view.size[2]; ++z) {
    for (std::int32_t y = 0; y < view.size[1]; ++y) {
      for (std::int32_t x = 0; x < view.size[0]; ++x) {
        if (view.cells[(z * view.size[1] + y) * view.size[0] + x] != mapping::kUnknownCell)
          distance[at(x / 4, y / 4, z / 4)] = 0;
      }
    }
  }
  for (int pass = 0; pass < 2; ++pass) {
    const int d = pass == 0 ? -1 : 1;
    for (std::int32_t k = 0; k < blocks[2]; ++k) {
      for (std::int32_t j = 0; j < blocks[1]; ++j) {
        for (std::int32_t i = 0; i < blocks[0]; ++i) {
          const std::int32_t x = pass == 0 ? i : blocks[0] - 1 - i;
          const std::int32_t y = pass == 0 ? j : blocks[1] - 1 - j;
          const std::int32_t z = pass == 0 ? k : blocks[2] - 1 - k;
          int& own = distance[at(x, y, z)];
          if (x + d >= 0 && x + d < blocks[0]) own = std::min(own, distance[at(x + d, y, z)] + 1);
          if (y + d >= 0 && y + d < blocks[1]) own = std::min(own, distance[at(x, y + d, z)] + 1);
          if (z + d >= 0 && z + d < blocks[2]) own = std::min(own, distance[at(x, y, z + d)] + 1);
        }
      }
    }
  }
  return distance;
}

/// A guess at every cell that was not measured, as a trained network would make it: sure and right near what
/// was measured, wavering and wrong in places away from it.
inline void guess_street(RayMap& map, const Street& street) {
  const mapping::OccupancyView view = map.map.view();
  std::int32_t blocks[3];
  const std::vector<int> distance = distance_to_measured(view, blocks);
  const auto noise = [&](std::int32_t x, std::int32_t y, std::int32_t z, std::int32_t grid,
                         std::uint64_t salt) {
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::int32_t c[3] = {x / grid + (corner & 1), y / grid + (corner >> 1 & 1),
                                 z / grid + (corner >> 2)};
      const double w[3] = {1.0 * (x % grid) / grid, 1.0 * (y % grid) / grid, 1.0 * (z % grid) / grid};
      double weight = 1;
      for (int a = 0; a < 3; ++a) weight *= (corner >> a & 1) != 0 ? w[a] : 1 - w[a];
      sum += weight * scene_share(salt + static_cast<std::uint64_t>((c[2] * 4096 + c[1]) * 4096 + c[0]));
    }
    return sum;
  };
  for (std::int32_t z = 0; z < view.size[2]; ++z) {
    for (std::int32_t y = 0; y < view.size[1]; ++y) {
      for (std::int32_t x = 0; x < view.size[0]; ++x) {
        const std::size_t index = static_cast<std::size_t>((z * view.size[1] + y) * view.size[0] + x);
        if (view.cells[index] != mapping::kUnknownCell) continue;
        const int away = distance[static_cast<std::size_t>((z / 4 * blocks[1] + y / 4) * blocks[0] + x / 4)];
        const double sure = 6.0 / (1.0 + 0.3 * away);
        const double wrong = noise(x, y, z, 6, street.seed() * 7919) - 0.5;
        const double odds = (street.solid(x, y, z) ? 0.7 : -1.0) * sure + 6.0 * wrong - 0.5;
        map.map.set(x, y, z, static_cast<int>(odds / mapping::kLogOddsStep));
      }
    }
  }
}

/// A street that was measured from nine places; `guessed`: with the guess at the rest.
inline void make_street(RayMap& map, std::uint64_t seed, const planner::RaySensor& sensor, bool guessed) {
  const Street street(map.map.config().size, seed);
  measure_street(map, street, sensor, 200);
  if (guessed) guess_street(map, street);
}

/// Names of the nine hard maps.
inline const std::vector<std::string>& hard_maps() {
  static const std::vector<std::string> names{"all unknown", "all free",  "p 0.5", "p 0.998",     "p 1e-4",
                                              "p 1e-7",      "saturated", "maze",  "nearly known"};
  return names;
}
/// One of them.
inline void make_hard_map(RayMap& map, std::size_t number) {
  const mapping::OccupancyView view = map.map.view();
  const double p[] = {0, 1e-4, 0.5, 0.998, 1e-4, 1e-7, 1, 0, 0};
  for (std::int32_t z = 0; z < view.size[2]; ++z) {
    for (std::int32_t y = 0; y < view.size[1]; ++y) {
      for (std::int32_t x = 0; x < view.size[0]; ++x) {
        int code = mapping::OccupancyMap::code_of(p[number]);
        const auto at = static_cast<std::uint64_t>((z * 4096 + y) * 4096 + x);
        if (number == 0) continue;
        if (number == 1) code = -mapping::kLogOddsLimit / 2;
        // Walls every 8 cells with doors; what lies between is half known.
        const bool wall = x % 8 == 0 || y % 8 == 0;
        const bool door = scene_share(at / 8 + 17) < 0.4;
        if (number == 7)
          code = wall && !door ? mapping::kLogOddsLimit : static_cast<int>(scene_share(at) * 40) - 40;
        if (number == 8) code = scene_share(at) < 1e-3 ? 0 : (scene_share(at + 9) < 0.02 ? 127 : -127);
        map.map.set(x, y, z, code);
      }
    }
  }
}

/// `count` poses, `spacing_m` apart along x, near the middle of a window.
inline std::vector<mapping::SensorPose> poses_ahead(const mapping::OccupancyView& view, std::size_t count,
                                                    double spacing_m) {
  std::vector<mapping::SensorPose> poses;
  for (std::size_t i = 0; i < count; ++i) {
    const double z = view.voxel_size_m * (view.low[2] + view.size[2] / 6 + 6) + 0.03;
    poses.push_back({{0.05 + spacing_m * static_cast<double>(i), 0.07, z}, {}});
  }
  return poses;
}

}  // namespace sortie::tests
