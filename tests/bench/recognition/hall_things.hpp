// SPDX-License-Identifier: BSD-3-Clause
// The things that stand about in made-up halls.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/bench/recognition/thing_hall.hpp"

namespace sortie::bench {

/// A thing about the origin: its parts, and a circle that holds them.
struct Thing {
  std::vector<HallSolid> parts;
  double radius{};

  void box(double x, double y, double half_x, double half_y, double height, double bottom = 0.0) {
    parts.push_back({{x, y, bottom}, half_x, half_y, height});
    radius = std::max(radius, std::hypot(std::fabs(x) + half_x, std::fabs(y) + half_y));
  }
  void cylinder(double r, double height) {
    HallSolid solid{{}, r, r, height};
    solid.round = true;
    parts.push_back(solid);
    radius = std::max(radius, r);
  }
};

/// A crate, a cylinder, a wall that stands by itself, a stack of pallets, an L, a T, stairs or a table; no
/// higher than `height`, m.
Thing draw_thing(testing::Draws& draws, double height);

/// Puts a thing down, turned by `yaw` about the vertical.
void put(std::vector<HallSolid>& solids, const Thing& thing, const rt::Vector3& at, double yaw);

}  // namespace sortie::bench
