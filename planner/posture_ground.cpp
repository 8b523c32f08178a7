// SPDX-License-Identifier: BSD-3-Clause
#include "planner/posture_ground.hpp"

#include <algorithm>
#include <cmath>

#include "rt/floor_divide.hpp"
#include "rt/math.hpp"

namespace sortie::planner {
namespace {

constexpr std::int64_t kParts = 1024;  // of a cell: where a sample lies is a whole number of them
constexpr double kFarthestPose_m = 1e5;
constexpr double kHighest_m = 1e4;

/// Whole parts of a cell, halves away from zero: the mirror image of a place has the mirrored number.
std::int64_t parts(double cells) {
  const auto whole = static_cast<std::int64_t>(std::fabs(cells) * static_cast<double>(kParts) + 0.5);
  return cells < 0.0 ? -whole : whole;
}

}  // namespace

GroundPatch::Heights GroundPatch::use(const HeightCell& cell, double edge_m) const {
  Heights heights;
  if (cell.state == HeightState::unknown || !(std::fabs(cell.high_m) < kHighest_m)) return heights;
  const bool known = cell.state == HeightState::known;
  if (known && !(cell.low_m <= cell.high_m && cell.low_m > -kHighest_m)) return heights;
  heights.high = static_cast<float>(cell.high_m);
  if (!known) return heights;
  heights.low = static_cast<float>(cell.low_m);
  const bool edge = cell.high_m - cell.low_m > edge_m;
  heights.height = edge ? heights.high : static_cast<float>(0.5 * (cell.low_m + cell.high_m));
  return heights;
}

GroundPatch::Heights GroundPatch::sample(std::int64_t u, std::int64_t v, double limit_m) const {
  // From here on u and v count from the middle of the window's first cell.
  const std::int64_t i = rt::floor_divide(u, kParts);
  const std::int64_t j = rt::floor_divide(v, kParts);
  const std::int64_t part_u = u - i * kParts;
  const std::int64_t part_v = v - j * kParts;
  const auto ahead = static_cast<float>(part_u) / static_cast<float>(kParts);
  const auto aside = static_cast<float>(part_v) / static_cast<float>(kParts);
  const float share_u[2] = {1.0F - ahead, ahead};
  const float share_v[2] = {1.0F - aside, aside};
  const std::size_t at = static_cast<std::size_t>(j) * kWindow + static_cast<std::size_t>(i);
  const Heights* corner[2][2] = {{&cells_[at], &cells_[at + kWindow]},
                                 {&cells_[at + 1], &cells_[at + 1 + kWindow]}};
  Heights across{-2e6F, 1e6F, -1e6F};  // over all four
  Heights slope{0.0F, 0.0F, 0.0F};
  float lowest = 2e6F;
  for (int k = 0; k < 2; ++k) {
    // A cell without a share has no say: in the mirror image it is the one on the other side.
    if (!(share_u[k] > 0.0F)) continue;
    // Across first, then along: the sum is the same in the mirror image.
    const Heights& right = *corner[k][share_v[0] > 0.0F ? 0 : 1];
    const Heights& left = *corner[k][share_v[1] > 0.0F ? 1 : 0];
    slope.height += share_u[k] * (share_v[0] * right.height + share_v[1] * left.height);
    slope.low += share_u[k] * (share_v[0] * right.low + share_v[1] * left.low);
    slope.high += share_u[k] * (share_v[0] * right.high + share_v[1] * left.high);
    lowest = std::min({lowest, right.height, left.height});
    across.height = std::max({across.height, right.height, left.height});
    across.low = std::min({across.low, right.low, left.low});
    across.high = std::max({across.high, right.high, left.high});
  }
  const auto limit = static_cast<float>(limit_m);
  const bool is_slope = across.height - lowest <= limit;
  if (is_slope && across.high - across.low <= limit) return slope;
  Heights most{-2e6F, 1e6F, -1e6F};  // over the cells that the sample may lie in
  for (int k = 0; k < 2; ++k) {
    for (int l = 0; l < 2; ++l) {
      if (share_u[k] < 0.5F || share_v[l] < 0.5F) continue;
      most.height = std::max(most.height, corner[k][l]->height);
      most.low = std::min(most.low, corner[k][l]->low);
      most.high = std::max(most.high, corner[k][l]->high);
    }
  }
  Heights out;
  out.height = is_slope ? slope.height : most.height;
  // A step or a slope, whichever the heights make it; a slope is within a step's limit of each of its ends.
  out.low = std::min(most.low, std::max(slope.low, most.low - limit));
  out.high = std::max(most.high, std::min(slope.high, most.high + limit));
  return out;
}

Status GroundPatch::fill(const HeightView& view, const StandPose& pose, const Config& config) {
  const double cell = view.cell_m;
  const double spacing = config.spacing_m;
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) || !std::isfinite(pose.yaw_rad) ||
      !std::isfinite(spacing) || !std::isfinite(cell) || !std::isfinite(config.step_slope) ||
      !std::isfinite(config.edge_m))
    return Status::not_finite;
  if (std::fabs(pose.x_m) > kFarthestPose_m || std::fabs(pose.y_m) > kFarthestPose_m || cell < 0.01 ||
      cell > 1.0 || spacing < 0.001 || spacing > 0.75 * cell || view.cell == nullptr)
    return Status::out_of_range;
  spacing_m_ = spacing;
  const rt::SinCos yaw = rt::sincos(pose.yaw_rad);
  const double ahead = spacing * kHalfColumns;
  const double aside = spacing * kHalfRows;
  const double reach_x = std::fabs(yaw.cos) * ahead + std::fabs(yaw.sin) * aside;
  const double reach_y = std::fabs(yaw.sin) * ahead + std::fabs(yaw.cos) * aside;
  const double per_cell = 1.0 / cell;
  // The cells whose middles lie around every sample, and one more for rounding.
  const std::int64_t half = kParts / 2;
  const std::int64_t first_i = rt::floor_divide(parts((pose.x_m - reach_x) * per_cell) - half, kParts) - 1;
  const std::int64_t first_j = rt::floor_divide(parts((pose.y_m - reach_y) * per_cell) - half, kParts) - 1;
  const std::int64_t last_i = rt::floor_divide(parts((pose.x_m + reach_x) * per_cell) - half, kParts) + 2;
  const std::int64_t last_j = rt::floor_divide(parts((pose.y_m + reach_y) * per_cell) - half, kParts) + 2;
  for (std::int64_t j = first_j; j <= last_j; ++j) {
    for (std::int64_t i = first_i; i <= last_i; ++i)
      cells_[static_cast<std::size_t>(j - first_j) * kWindow + static_cast<std::size_t>(i - first_i)] =
          use(view.cell(view.ground, i, j), config.edge_m);
  }
  const double limit = config.step_slope * cell;
  for (int row = -kHalfRows; row <= kHalfRows; ++row) {
    for (int column = -kHalfColumns; column <= kHalfColumns; ++column) {
      const double x = spacing * column;
      const double y = spacing * row;
      const std::int64_t u = parts((pose.x_m + (yaw.cos * x - yaw.sin * y)) * per_cell);
      const std::int64_t v = parts((pose.y_m + (yaw.sin * x + yaw.cos * y)) * per_cell);
      const Heights here = sample(u - half - first_i * kParts, v - half - first_j * kParts, limit);
      const std::size_t at = index(column, row);
      height_[at] = here.height;
      low_[at] = here.low;
      high_[at] = here.high;
    }
  }
  return Status::ok;
}

void GroundPatch::mirror() {
  for (int row = 1; row <= kHalfRows; ++row) {
    for (int column = -kHalfColumns; column <= kHalfColumns; ++column) {
      std::swap(height_[index(column, row)], height_[index(column, -row)]);
      std::swap(low_[index(column, row)], low_[index(column, -row)]);
      std::swap(high_[index(column, row)], high_[index(column, -row)]);
    }
  }
}

int GroundPatch::handedness() const {
  for (int row = kHalfRows; row > 0; --row) {
    for (int column = -kHalfColumns; column <= kHalfColumns; ++column) {
      const float left = height(column, row);
      const float right = height(column, -row);
      if (left != right) return left > right ? -1 : 1;
    }
  }
  return 0;
}

}  // namespace sortie::planner
