// SPDX-License-Identifier: BSD-3-Clause
// Buildings that a robot may be lost in: rooms, corridors, storeys, things that stand about and may be moved.
// Made for the search of places, shares nothing with it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

inline constexpr double kNowhere = std::numeric_limits<double>::infinity();

/// Boxes turned about z, found through a grid in the plane. Rays are cast in about a microsecond.
class PlaceWorld {
 public:
  struct Box {
    rt::Vector3 middle, half;
    double yaw{};
  };
  std::vector<Box> boxes;
  double wide{}, deep{};  ///< m; the world is [0, wide] x [0, deep]
  std::vector<double> floors{0.0};
  double storey{3.0};
  std::size_t first_thing{};  ///< the boxes from here on stand about; those before are the building

  void add(const rt::Vector3& low, const rt::Vector3& high) {
    boxes.push_back({0.5 * (low + high), 0.5 * (high - low), 0});
  }

  /// To be called when all boxes are there.
  void index() {
    shaped_.clear();
    nx_ = static_cast<int>(std::ceil((wide + 2 * kEdge) / kCell));
    ny_ = static_cast<int>(std::ceil((deep + 2 * kEdge) / kCell));
    cells_.assign(static_cast<std::size_t>(nx_ * ny_), {});
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Box& b = boxes[i];
      const double c = std::cos(b.yaw), s = std::sin(b.yaw);
      shaped_.push_back({b.middle, b.half, c, s});
      const double rx = std::fabs(c) * b.half.x + std::fabs(s) * b.half.y;
      const double ry = std::fabs(s) * b.half.x + std::fabs(c) * b.half.y;
      for (int y = at(b.middle.y - ry, ny_); y <= at(b.middle.y + ry, ny_); ++y) {
        for (int x = at(b.middle.x - rx, nx_); x <= at(b.middle.x + rx, nx_); ++x)
          cells_[static_cast<std::size_t>(y * nx_ + x)].push_back(static_cast<int>(i));
      }
    }
  }

  /// Distance along a ray to the nearest surface, or infinity beyond `most`.
  double range(const rt::Vector3& from, const rt::Vector3& ray, double most) const {
    double least = kNowhere;
    int x = at(from.x, nx_), y = at(from.y, ny_);
    const double inv_x = 1.0 / ray.x, inv_y = 1.0 / ray.y;
    const int sx = ray.x > 0 ? 1 : -1, sy = ray.y > 0 ? 1 : -1;
    double tx = ray.x == 0.0 ? kNowhere : ((x + (sx > 0)) * kCell - kEdge - from.x) * inv_x;
    double ty = ray.y == 0.0 ? kNowhere : ((y + (sy > 0)) * kCell - kEdge - from.y) * inv_y;
    double t = 0.0;
    while (t < most && t < least && x >= 0 && y >= 0 && x < nx_ && y < ny_) {
      for (const int i : cells_[static_cast<std::size_t>(y * nx_ + x)])
        least = std::min(least, hit(shaped_[static_cast<std::size_t>(i)], from, ray));
      if (tx < ty) {
        t = tx, x += sx, tx += std::fabs(kCell * inv_x);
      } else {
        t = ty, y += sy, ty += std::fabs(kCell * inv_y);
      }
    }
    return least > most ? kNowhere : least;
  }

  /// Whether a ball is free of surfaces.
  bool is_free(const rt::Vector3& p, double radius) const {
    for (const Shaped& b : shaped_) {
      const rt::Vector3 o = p - b.middle;
      const double x = std::fabs(b.c * o.x + b.s * o.y) - b.half.x;
      const double y = std::fabs(-b.s * o.x + b.c * o.y) - b.half.y;
      if (x < radius && y < radius && std::fabs(o.z) - b.half.z < radius) return false;
    }
    return true;
  }

 private:
  static constexpr double kCell = 2.0, kEdge = 2.0;
  struct Shaped {
    rt::Vector3 middle, half;
    double c, s;
  };
  static int at(double v, int n) {
    return std::clamp(static_cast<int>(std::floor((v + kEdge) / kCell)), 0, n - 1);
  }
  static double hit(const Shaped& b, const rt::Vector3& from, const rt::Vector3& ray) {
    const rt::Vector3 o = from - b.middle;
    const double oo[3] = {b.c * o.x + b.s * o.y, -b.s * o.x + b.c * o.y, o.z};
    const double dd[3] = {b.c * ray.x + b.s * ray.y, -b.s * ray.x + b.c * ray.y, ray.z};
    const double hh[3] = {b.half.x, b.half.y, b.half.z};
    double near = -kNowhere, far = kNowhere;
    for (int i = 0; i < 3; ++i) {
      if (dd[i] == 0.0) {
        if (std::fabs(oo[i]) > hh[i]) return kNowhere;
        continue;
      }
      const double a = (-hh[i] - oo[i]) / dd[i], c = (hh[i] - oo[i]) / dd[i];
      near = std::max(near, std::min(a, c));
      far = std::min(far, std::max(a, c));
    }
    return near > far || near <= 1e-6 ? kNowhere : near;
  }

  int nx_{}, ny_{};
  std::vector<Shaped> shaped_;
  std::vector<std::vector<int>> cells_;
};

/// Things on the floor of a rectangle, clear of its walls.
inline void add_things(PlaceWorld& world, Draws& draws, const rt::Vector3& low, const rt::Vector3& high,
                       int count) {
  for (int i = 0; i < count; ++i) {
    const double tall = draws.uniform(0, 1) < 0.15 ? 0.5 * (high.z - low.z) : draws.uniform(0.2, 1.0);
    const rt::Vector3 half{draws.uniform(0.1, 0.8), draws.uniform(0.1, 0.6), tall};
    if (high.x - low.x < 1.0 || high.y - low.y < 1.0) continue;
    world.boxes.push_back(
        {{draws.uniform(low.x + 0.3, high.x - 0.3), draws.uniform(low.y + 0.3, high.y - 0.3), low.z + tall},
         half,
         draws.uniform(0, 1) < 0.5 ? 0.0 : draws.uniform(0, M_PI)});
  }
}

/// A wall along x or y with gaps (doors, 2.1 m high) at the given places along it.
inline void add_wall(PlaceWorld& world, bool along_x, double at, double from, double to, double z,
                     double high, const std::vector<double>& doors) {
  constexpr double kHalf = 0.08, kDoor = 0.5, kDoorHigh = 2.1;
  const auto piece = [&](double a, double b, double low, double up) {
    if (b <= a) return;
    if (along_x)
      world.add({a, at - kHalf, low}, {b, at + kHalf, up});
    else
      world.add({at - kHalf, a, low}, {at + kHalf, b, up});
  };
  double last = from;
  for (const double door : doors) {
    piece(last, door - kDoor, z, z + high);
    piece(door - kDoor, door + kDoor, z + kDoorHigh, z + high);
    last = door + kDoor;
  }
  piece(last, to, z, z + high);
}

/// Floors, ceilings and the walls around.
inline void add_shell(PlaceWorld& world) {
  const double top = world.floors.back() + world.storey;
  for (const double z : world.floors)
    world.add({-0.2, -0.2, z - 0.2}, {world.wide + 0.2, world.deep + 0.2, z});
  world.add({-0.2, -0.2, top}, {world.wide + 0.2, world.deep + 0.2, top + 0.2});
  for (const double x : {-0.1, world.wide + 0.1})
    world.add({x - 0.1, -0.2, -0.2}, {x + 0.1, world.deep + 0.2, top});
  for (const double y : {-0.1, world.deep + 0.1})
    world.add({-0.2, y - 0.1, -0.2}, {world.wide + 0.2, y + 0.1, top});
}

/// Storeys of rooms on both sides of a corridor, some of them as wide as their neighbours, some halls.
inline PlaceWorld random_building(Draws& draws, double wide, double deep, int storeys) {
  PlaceWorld world;
  world.wide = wide;
  world.deep = deep;
  world.storey = draws.uniform(2.6, 3.8);
  world.floors.clear();
  for (int i = 0; i < storeys; ++i) world.floors.push_back(i * (world.storey + 0.2));
  add_shell(world);
  struct Room {
    rt::Vector3 low, high;
  };
  std::vector<Room> rooms;
  const double corridor = draws.uniform(1.8, 3.0);
  const double at = deep * draws.uniform(0.4, 0.6);
  const bool alike = draws.uniform(0, 1) < 0.5;
  const double usual = draws.uniform(3.5, 6.5);
  for (const double z : world.floors) {
    const double up = z + world.storey;
    for (const bool left : {true, false}) {
      const double low = left ? 0.0 : at + 0.5 * corridor, high = left ? at - 0.5 * corridor : deep;
      std::vector<double> doors;
      for (double x = 0.0; x < wide - 0.01;) {
        const double hall = draws.uniform(0, 1) < 0.12 ? 2.0 : 1.0;
        double next = x + hall * (alike ? usual : draws.uniform(3.0, 8.0));
        if (next > wide - 2.5) next = wide;
        doors.push_back(draws.uniform(x + 0.8, next - 0.8));
        rooms.push_back({{x, low, z}, {next, high, up}});
        if (next < wide) add_wall(world, false, next, low, high, z, world.storey, {});
        x = next;
      }
      add_wall(world, true, left ? high : low, 0, wide, z, world.storey, doors);
    }
    rooms.push_back({{0, at - 0.5 * corridor, z}, {wide, at + 0.5 * corridor, up}});
  }
  world.first_thing = world.boxes.size();
  for (const Room& room : rooms) {
    const double area = (room.high.x - room.low.x) * (room.high.y - room.low.y);
    const bool is_corridor = room.high.x - room.low.x > 0.99 * wide;
    add_things(
        world, draws, room.low, room.high,
        static_cast<int>(area * (is_corridor ? draws.uniform(0.02, 0.08) : draws.uniform(0.1, 0.3))) + 1);
  }
  world.index();
  return world;
}

/// One hall with columns and things.
inline PlaceWorld random_place_hall(Draws& draws) {
  PlaceWorld world;
  world.wide = draws.uniform(7, 30);
  world.deep = draws.uniform(6, 20);
  world.storey = draws.uniform(2.6, 6);
  add_shell(world);
  for (int i = static_cast<int>(draws.uniform(0, 5)); i > 0; --i) {
    const double x = draws.uniform(0.5, world.wide), y = draws.uniform(0.5, world.deep);
    const double half = draws.uniform(0.1, 0.4);
    world.add({x - half, y - half, 0}, {x + half, y + half, world.storey});
  }
  world.first_thing = world.boxes.size();
  add_things(world, draws, {0, 0, 0}, {world.wide, world.deep, world.storey},
             6 + static_cast<int>(draws.uniform(0, 0.12) * world.wide * world.deep));
  world.index();
  return world;
}

/// The same seen in a mirror: x is -x.
inline PlaceWorld mirrored(const PlaceWorld& world) {
  PlaceWorld out = world;
  for (PlaceWorld::Box& box : out.boxes) {
    box.middle.x = out.wide - box.middle.x;
    box.yaw = -box.yaw;
  }
  out.index();
  return out;
}

/// The same turned by half a turn about its middle, on top of itself: both ends look alike.
inline PlaceWorld symmetric(const PlaceWorld& world) {
  PlaceWorld out = world;
  for (const PlaceWorld::Box& box : world.boxes) {
    out.boxes.push_back(box);
    out.boxes.back().middle.x = out.wide - box.middle.x;
    out.boxes.back().middle.y = out.deep - box.middle.y;
  }
  out.index();
  return out;
}

/// A part of the things stand elsewhere, or are gone.
inline PlaceWorld moved(const PlaceWorld& world, Draws& draws, double share) {
  PlaceWorld out = world;
  for (std::size_t i = out.first_thing; i < out.boxes.size(); ++i) {
    if (draws.uniform(0, 1) >= share) continue;
    PlaceWorld::Box& box = out.boxes[i];
    box.middle.x = std::clamp(box.middle.x + draws.uniform(-3, 3), 0.3, out.wide - 0.3);
    box.middle.y = std::clamp(box.middle.y + draws.uniform(-3, 3), 0.3, out.deep - 0.3);
    box.yaw = draws.uniform(0, M_PI);
  }
  out.index();
  return out;
}

/// A place where a robot of 0.4 m may stand.
inline rt::Vector3 free_place(const PlaceWorld& world, Draws& draws) {
  for (;;) {
    const auto floor = static_cast<std::size_t>(draws.uniform(0, static_cast<double>(world.floors.size())));
    const rt::Vector3 p{draws.uniform(0.5, world.wide - 0.5), draws.uniform(0.5, world.deep - 0.5),
                        world.floors[floor] + draws.uniform(0.5, 1.2)};
    if (world.is_free(p, 0.4)) return p;
  }
}

/// Returns of a lidar in such a world.
inline std::vector<rt::ScanPoint> place_scan(const TestLidar& lidar, const PlaceWorld& world,
                                             const rt::Vector3& p, const rt::Quaternion& q, Draws& draws) {
  std::vector<rt::ScanPoint> out;
  for (int row = 0; row < lidar.rows; ++row) {
    const double up = lidar.low_rad + (lidar.high_rad - lidar.low_rad) * row / (lidar.rows - 1);
    for (int column = 0; column < lidar.columns; ++column) {
      const double turn = 2.0 * M_PI * (column + 0.5) / lidar.columns;
      const rt::Vector3 ray{std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)};
      const double range = world.range(p, rt::rotate(q, ray), lidar.most_m);
      if (range > lidar.most_m) continue;
      const double seen = range + lidar.noise_m * draws.normal();
      out.push_back({static_cast<float>(seen * ray.x), static_cast<float>(seen * ray.y),
                     static_cast<float>(seen * ray.z), 0, 0});
    }
  }
  return out;
}

/// 16, 32 or 64 rows.
inline TestLidar random_lidar(Draws& draws) {
  switch (static_cast<int>(draws.uniform(0, 3))) {
    case 0:
      return {16, 720, -0.26, 0.26};
    case 1:
      return {32, 512, -0.5, 0.3};
    default:
      return {64, 360, -0.6, 0.6};
  }
}

}  // namespace sortie::testing
