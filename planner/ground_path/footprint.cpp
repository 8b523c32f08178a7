// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_path/footprint.hpp"

#include <algorithm>

namespace sortie::planner {
namespace {

constexpr std::int32_t kTurnSamples = 16;  // between two headings: 1.8 degrees at the most

constexpr std::int64_t root_floor(std::int64_t square) {
  std::int64_t root = 0;
  for (std::int64_t bit = std::int64_t{1} << 30; bit > 0; bit /= 2)
    if ((root + bit) * (root + bit) <= square) root += bit;
  return root;
}
constexpr std::int64_t magnitude(std::int64_t value) { return value < 0 ? -value : value; }

// The rectangle along (a, b) and a square around a cell, as separating axes tell: true unless one of them
// keeps them apart for certain.
struct Rectangle {
  std::int64_t half_length_mm{};
  std::int64_t half_width_mm{};
  std::int64_t a{};
  std::int64_t b{};

  bool touches(std::int64_t x_mm, std::int64_t y_mm, std::int64_t half_mm) const {
    const std::int64_t low = root_floor(a * a + b * b);
    const std::int64_t sum = magnitude(a) + magnitude(b);
    if (magnitude(x_mm * a + y_mm * b) > half_length_mm * (low + 1) + half_mm * sum) return false;
    if (magnitude(y_mm * a - x_mm * b) > half_width_mm * (low + 1) + half_mm * sum) return false;
    if ((magnitude(x_mm) - half_mm) * low > half_length_mm * magnitude(a) + half_width_mm * magnitude(b))
      return false;
    return (magnitude(y_mm) - half_mm) * low <= half_length_mm * magnitude(b) + half_width_mm * magnitude(a);
  }
};

struct Direction {
  std::int64_t a{};
  std::int64_t b{};
};
constexpr Direction long_direction(std::int32_t heading) {
  const CellStep step = kHeadingSteps[static_cast<std::size_t>(wrap_heading(heading))];
  const std::int64_t length = step_length_q16(heading);
  return {(step.x * std::int64_t{10'000} << 16) / length, (step.y * std::int64_t{10'000} << 16) / length};
}

}  // namespace

FootprintTable::FootprintTable(const GroundPathConfig& config) {
  if (check(config) != Status::ok) return;
  const std::int64_t length = config.half_length_mm;
  const std::int64_t width = config.half_width_mm;
  // Between two samples a corner moves by its radius times 0.9 degrees at the most.
  const std::int64_t wider_mm = (root_floor(length * length + width * width) + 1) * 16 / 1000 + 1;
  for (std::int32_t h = 0; h < kHeadings; ++h) {
    const Direction from = long_direction(h);
    const Direction to = long_direction(h + 1);
    add(h, config, from.a, from.b, 0);
    for (std::int32_t k = 0; k <= kTurnSamples; ++k)
      add(kHeadings + h, config, (kTurnSamples - k) * from.a + k * to.a,
          (kTurnSamples - k) * from.b + k * to.b, wider_mm);
  }
  for (std::size_t y = 0; y < rows_[0].size(); ++y) {
    FootprintRow core = rows_[0][y];
    for (std::size_t h = 1; h < kHeadings; ++h) {
      core.low = std::max(core.low, rows_[h][y].low);
      core.high = std::min(core.high, rows_[h][y].high);
    }
    rows_[kCore][y] = core;
  }
  for (std::size_t slot = 0; slot < rows_.size(); ++slot) {
    for (std::int32_t y = -kMostReach; y <= kMostReach; ++y) {
      const FootprintRow& cells = row(static_cast<std::int32_t>(slot), y);
      if (cells.low > cells.high) continue;
      reaches_[slot] = std::max({reaches_[slot], y, -y, std::int32_t{cells.high}, -std::int32_t{cells.low}});
    }
    reach_ = std::max(reach_, reaches_[slot]);
  }
}

void FootprintTable::add(std::int32_t slot, const GroundPathConfig& config, std::int64_t a, std::int64_t b,
                         std::int64_t wider_mm) {
  const Rectangle robot{config.half_length_mm + wider_mm, config.half_width_mm + wider_mm, a, b};
  // Half a cell of its own, and what the robot's middle may be away from its cell's: a half and a sixteenth.
  const std::int64_t half_mm = (17 * config.cell_mm + 15) / 16;
  for (std::int32_t y = -kMostReach; y <= kMostReach; ++y) {
    FootprintRow& cells = rows_[static_cast<std::size_t>(slot)][static_cast<std::size_t>(y + kMostReach)];
    for (std::int32_t x = -kMostReach; x <= kMostReach; ++x) {
      if (!robot.touches(x * config.cell_mm, y * config.cell_mm, half_mm)) continue;
      const bool none = cells.low > cells.high;
      cells.low = static_cast<std::int8_t>(none ? x : std::min<std::int32_t>(x, cells.low));
      cells.high = static_cast<std::int8_t>(none ? x : std::max<std::int32_t>(x, cells.high));
    }
  }
}

}  // namespace sortie::planner
