// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/elevation/elevation_view.hpp"

#include <cmath>

#include "mapping/elevation/elevation_units.hpp"
#include "rt/floor_divide.hpp"

namespace sortie::mapping {

namespace {

constexpr double kFarthest_m = 1e9;

double sigma_of(std::uint16_t weight) { return std::sqrt(kUnitWeightVariance_m2 / weight); }

}  // namespace

std::int64_t ElevationView::cell_of(double world_m) const {
  return rt::floor_divide(unit_below(world_m * kGroundUnits), cell_units);
}

GroundSpan ElevationView::ground(std::int64_t x, std::int64_t y, double asker_m,
                                 const LevelRule& rule) const {
  GroundSpan span;
  if (cells == nullptr || !contains(x, y) || !std::isfinite(asker_m)) return span;
  const std::uint32_t at = index(x, y);
  const ElevationCell& cell = cells[at];
  const auto level = static_cast<double>(level_m);
  const auto height_m = [&](std::uint32_t i) { return level + cell.height[i] / kHeightUnits; };
  // Where surfaces were put together for want of room, something was seen that none of them tells of.
  const bool is_filled = ((cell.flags[0] | cell.flags[1] | cell.flags[2] | cell.flags[3]) & kFilled) != 0;
  const auto is_free = [&](std::uint32_t under) {
    return !is_filled && height_m(under + 1) - height_m(under) >= rule.clearance_m;
  };
  const auto only_from_below = [&](std::uint32_t i) { return (cell.flags[i] & ~kFilled) == kSeenFromBelow; };
  if (bounds[at] != kNoBound) {
    span.bound_m = level + bounds[at] / kHeightUnits;
    span.has_bound = span.bound_m >= asker_m - rule.reach_m;
    if (!span.has_bound) span.bound_m = 0.0;
    if (span.has_bound) span.state = GroundState::bounded;
  }
  // Levels from the lowest: the last one that begins low enough is the ground.
  const std::uint32_t n = cell.surfaces();
  std::uint32_t first = n;
  std::uint32_t last = n;
  for (std::uint32_t begin = 0; begin < n;) {
    std::uint32_t end = begin + 1;
    while (end < n && !is_free(end - 1)) ++end;
    if (height_m(begin) > asker_m + rule.climb_m) {
      span.has_ceiling = true;
      span.ceiling_m = height_m(begin);
      break;
    }
    first = begin;
    last = end - 1;
    begin = end;
  }
  if (first == n) return span;
  const std::uint32_t lowest = first;
  while (first < last && only_from_below(first)) ++first;
  span.from_below = only_from_below(last);
  // Nothing in it was seen from above: all of it counts.
  if (first == last && span.from_below) first = lowest;
  span.state = (cell.flags[last] & kFelt) != 0 ? GroundState::felt : GroundState::measured;
  span.low_m = height_m(first);
  span.high_m = height_m(last);
  const std::uint16_t of_low = aged_weight(cell.weight[first], cell.variance, variance);
  const std::uint16_t of_high = aged_weight(cell.weight[last], cell.variance, variance);
  span.sigma_m = sigma_of(of_low < of_high ? of_low : of_high);
  return span;
}

GroundSpan ElevationView::ground_at(double x_m, double y_m, double asker_m, const LevelRule& rule) const {
  if (cells == nullptr || !(std::fabs(x_m) < kFarthest_m) || !(std::fabs(y_m) < kFarthest_m)) return {};
  return ground(cell_of(x_m), cell_of(y_m), asker_m, rule);
}

}  // namespace sortie::mapping
