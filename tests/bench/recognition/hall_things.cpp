// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/hall_things.hpp"

namespace sortie::bench {
namespace {
using testing::Draws;

Thing draw_stairs(Draws& draws) {
  Thing thing;
  const int steps = 3 + static_cast<int>(draws.uniform(0, 4));
  const double depth = draws.uniform(0.25, 0.35), rise = draws.uniform(0.15, 0.2);
  const double half = draws.uniform(0.5, 0.9);
  for (int i = 0; i < steps; ++i) thing.box(depth * (i - 0.5 * steps), 0, 0.5 * depth, half, rise * (i + 1));
  return thing;
}

Thing draw_table(Draws& draws) {
  Thing thing;
  const double x = draws.uniform(0.6, 1.1), y = draws.uniform(0.35, 0.5);
  thing.box(0, 0, x, y, 0.05, 0.75);
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) thing.box(sx * (x - 0.06), sy * (y - 0.06), 0.04, 0.04, 0.75);
  }
  return thing;
}

}  // namespace

Thing draw_thing(Draws& draws, double height) {
  Thing thing;
  const double a = draws.uniform(0.8, 1.8), b = draws.uniform(0.6, 1.6), thick = draws.uniform(0.15, 0.35);
  const double up = draws.uniform(1.0, 2.2);
  switch (static_cast<int>(draws.uniform(0, 8))) {
    case 0:
      thing.box(0, 0, 0.45 * a, 0.4 * b, 0.7 * up);
      break;
    case 1:
      thing.cylinder(draws.uniform(0.25, 0.6), up);
      break;
    case 2:  // a wall that stands by itself
      thing.box(0, 0, a, 0.08, std::min(height, 1.3 * up));
      break;
    case 3:  // a stack of pallets, goods on it
      thing.box(0, 0, 0.6, 0.4, draws.uniform(0.3, 0.8));
      thing.box(0, 0, draws.uniform(0.3, 0.55), draws.uniform(0.25, 0.38), up);
      break;
    case 4:  // L
      thing.box(0, 0, a, thick, up);
      thing.box(a - thick, b, thick, b, up);
      break;
    case 5:  // T
      thing.box(0, 0, a, thick, up);
      thing.box(0, b, thick, b, up);
      break;
    case 6:
      return draw_stairs(draws);
    default:
      return draw_table(draws);
  }
  return thing;
}

void put(std::vector<HallSolid>& solids, const Thing& thing, const rt::Vector3& at, double yaw) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (HallSolid part : thing.parts) {
    part.foot = {at.x + c * part.foot.x - s * part.foot.y, at.y + s * part.foot.x + c * part.foot.y,
                 part.foot.z};
    part.cosine = c;
    part.sine = s;
    solids.push_back(part);
  }
}

}  // namespace sortie::bench
