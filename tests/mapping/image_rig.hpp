// SPDX-License-Identifier: BSD-3-Clause
// Drawn places seen from above, images of them from anywhere, and a store that takes these.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "mapping/recognition/image_store.hpp"
#include "tests/mapping/registration_world.hpp"

namespace sortie::testing {

/// A store with its memory.
struct OwnedImages {
  explicit OwnedImages(const mapping::ImageStoreConfig& config = {})
      : memory(std::size_t{config.images} * sizeof(mapping::ImageRecord) + 4096),
        arena(memory),
        store(config, arena) {}
  std::vector<std::byte> memory;
  rt::Arena arena;
  mapping::ImageStore store;
};

/// Walls in the plane, m.
struct DrawnPlace {
  struct Wall {
    double x, y, to_x, to_y;
    bool low, high;
  };
  std::vector<Wall> walls;

  void box(double x, double y, double to_x, double to_y, bool high = true) {
    walls.push_back({x, y, to_x, y, true, high});
    walls.push_back({x, to_y, to_x, to_y, true, high});
    walls.push_back({x, y, x, to_y, true, high});
    walls.push_back({to_x, y, to_x, to_y, true, high});
  }
};

/// Where an image is made.
struct DrawnPose {
  double x{}, y{}, yaw{};
};

/// A room of 10 to 18 m with boxes in it, some of them low.
inline DrawnPlace draw_place(Draws& draws, int boxes) {
  DrawnPlace place;
  const double half_x = draws.uniform(5, 9), half_y = draws.uniform(4, 7);
  place.box(-half_x, -half_y, half_x, half_y);
  for (int i = 0; i < boxes; ++i) {
    const double x = draws.uniform(-half_x, half_x - 1), y = draws.uniform(-half_y, half_y - 1);
    place.box(x, y, x + draws.uniform(0.2, 1.0), y + draws.uniform(0.2, 1.0), draws.uniform(0, 1) < 0.6);
  }
  return place;
}

/// What is seen from a pose up to `reach_m` away: nine of ten cells of walls, each up to 2 cm off, and eight
/// of ten cells of the room's floor.
inline mapping::HeightImage image_of(const DrawnPlace& place, const DrawnPose& from, double reach_m,
                                     Draws& draws) {
  mapping::HeightImage image;
  const double c = std::cos(from.yaw), s = std::sin(from.yaw);
  const auto put = [&](mapping::ImagePlane& plane, double x, double y) {
    const double dx = x - from.x, dy = y - from.y;
    if (dx * dx + dy * dy > reach_m * reach_m) return;
    const auto cell = [](double m) { return static_cast<std::int32_t>(std::floor(m / 0.2)) + 64; };
    const std::int32_t column = cell(c * dx + s * dy), row = cell(c * dy - s * dx);
    if (mapping::ImagePlane::holds(column, row)) plane.set(column, row);
  };
  for (const DrawnPlace::Wall& wall : place.walls) {
    const double length = std::hypot(wall.to_x - wall.x, wall.to_y - wall.y);
    for (double at = 0.0; at < length; at += 0.1) {
      const double x = wall.x + at / length * (wall.to_x - wall.x) + draws.uniform(-0.02, 0.02);
      const double y = wall.y + at / length * (wall.to_y - wall.y) + draws.uniform(-0.02, 0.02);
      if (draws.uniform(0, 1) < 0.1) continue;
      if (wall.low) put(image.low, x, y);
      if (wall.high) put(image.high, x, y);
    }
  }
  const DrawnPlace::Wall& low = place.walls[0];
  const DrawnPlace::Wall& right = place.walls[3];
  for (double x = low.x; x < low.to_x; x += 0.2) {
    for (double y = right.y; y < right.to_y; y += 0.2) {
      if (draws.uniform(0, 1) < 0.8) put(image.floor, x, y);
    }
  }
  return image;
}

/// A pose in the map as an image has it.
inline mapping::KeyFramePose key_frame_of(const DrawnPose& pose) {
  mapping::KeyFramePose out;
  out.place = {static_cast<std::int32_t>(std::lround(100 * pose.x)),
               static_cast<std::int32_t>(std::lround(100 * pose.y)), 0};
  static_cast<void>(mapping::heading_of(std::cos(pose.yaw), std::sin(pose.yaw), out.heading));
  return out;
}

}  // namespace sortie::testing
