// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/grid/reach.hpp"

#include <cmath>
#include <cstdlib>

namespace sortie::mapping {

Reach::Reach(double radius_cells) {
  if (!(radius_cells > 0.0 && radius_cells <= kMostCells)) return;
  const double units = radius_cells * 65536.0;
  squared_radius_ = static_cast<std::int64_t>(std::floor(units * units));
  // Two half-open cells n apart hold points that are more than n - 1 apart.
  const auto gap = [](int delta) {
    const int away = delta < 0 ? -delta : delta;
    return away > 0 ? away - 1 : 0;
  };
  for (int direction = 0; direction < kDirections; ++direction) {
    const BlockAt step = BlockAt{}.next(direction);
    for (unsigned a = 0; a < Block::kCells; ++a) {
      std::uint64_t mask = 0;
      for (unsigned b = 0; b < Block::kCells; ++b) {
        if (direction == kHere && a == b) continue;
        const auto delta = [a, b](int shift, int block) {
          return 4 * block + static_cast<int>(b >> shift & 3) - static_cast<int>(a >> shift & 3);
        };
        const int x = gap(delta(0, step.x));
        const int y = gap(delta(2, step.y));
        const int z = gap(delta(4, step.z));
        if (x * x + y * y + z * z <= radius_cells * radius_cells) mask |= cell_bit(b);
        if (direction != kHere || x + y + z != 0) continue;
        close_[a] |= mask & cell_bit(b);
        const int steps = std::abs(delta(0, 0)) + std::abs(delta(2, 0)) + std::abs(delta(4, 0));
        if (steps == 1) beside_[a] |= mask & cell_bit(b);
      }
      cells_[direction][a] = mask;
      if (mask != 0) rim_[direction] |= cell_bit(a);
    }
  }
}

}  // namespace sortie::mapping
