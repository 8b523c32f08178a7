// SPDX-License-Identifier: BSD-3-Clause
// Cells of the terrain: what is read of the elevation, and which of them carry.
#include <algorithm>
#include <cmath>

#include "mapping/elevation/elevation_cell.hpp"
#include "mapping/elevation/elevation_units.hpp"
#include "planner/ground_way/ground_terrain.hpp"

namespace sortie::planner {

namespace {

using Elevation = mapping::GroundState;

std::int32_t mm_size(std::int32_t v) { return v < 0 ? -v : v; }

/// A surface that was seen from below alone says that something is there, not that it carries: it counts as
/// the top of a wall, and not at all where nothing below it was seen.
bool is_solid(const mapping::GroundSpan& span, double step_m) {
  return (span.state == Elevation::measured || span.state == Elevation::felt) &&
         (!span.from_below || span.high_m - span.low_m > step_m);
}

/// Takes out of a cell what was met by one return or two, while a ray passed below it: a beam that meets an
/// edge gives such returns, in the middle of nothing. What is left is the ground under it, or nothing. A
/// weight of one return at 1 m is about 2800.
void leave_out_ghost(const mapping::ElevationView& view, std::int64_t x, std::int64_t y, double step_m,
                     mapping::GroundSpan& span) {
  constexpr std::uint32_t kOfTwo = 5000;
  if (!span.has_bound || span.state != Elevation::measured) return;
  const mapping::ElevationCell& cell = view.cells[view.index(x, y)];
  const bool is_free = view.evidence[view.index(x, y)].is_free();
  const bool has_ground = span.low_m <= span.bound_m + step_m;
  const double above_m = has_ground ? span.low_m + step_m : span.bound_m;
  std::uint32_t weight = 0;
  double least_m = span.high_m;
  for (std::uint32_t i = 0; i < cell.surfaces(); ++i) {
    const double height_m = static_cast<double>(view.level_m) + cell.height[i] / mapping::kHeightUnits;
    if ((cell.flags[i] & mapping::kFilled) != 0 && !is_free) return;
    if (height_m <= above_m) continue;
    weight += cell.weight[i];
    least_m = std::min(least_m, height_m);
  }
  if (weight == 0 || (weight >= kOfTwo && !is_free) || span.bound_m >= least_m) return;
  if (!has_ground) {
    span.state = Elevation::bounded;
    return;
  }
  span.high_m = span.low_m;
  span.from_below = false;
}

}  // namespace

void GroundTerrain::read_columns(const mapping::ElevationView& view, double asker_m, std::int32_t x0,
                                 std::int32_t y0, std::int32_t x1, std::int32_t y1) {
  const auto add = [this](const mapping::GroundSpan& span, Surface& surface) {
    if (!is_solid(span, rules_.most_step_m) || std::fabs(span.low_m - level_m_) > 31.0 ||
        std::fabs(span.high_m - level_m_) > 31.0)
      return;
    const std::int16_t low_mm = to_mm(span.low_m);
    const std::int16_t high_mm = to_mm(span.high_m);
    surface.low_mm = surface.known != 0 ? std::min(surface.low_mm, low_mm) : low_mm;
    surface.high_mm = surface.known != 0 ? std::max(surface.high_mm, high_mm) : high_mm;
    surface.known = 1;
  };
  for (std::int32_t y = y0; y <= y1; ++y) {
    for (std::int32_t x = x0; x <= x1; ++x) {
      Column column;
      for (std::int32_t sy = 0; sy < per_cell_; ++sy) {
        for (std::int32_t sx = 0; sx < per_cell_; ++sx) {
          const std::int64_t ex = (low_[0] + x) * per_cell_ + sx;
          const std::int64_t ey = (low_[1] + y) * per_cell_ + sy;
          mapping::GroundSpan ground = view.ground(ex, ey, asker_m);
          leave_out_ghost(view, ex, ey, rules_.most_step_m, ground);
          add(ground, column.surface[0]);
          if (ground.has_bound && ground.state == Elevation::bounded)
            column.bound_mm = std::min(column.bound_mm, to_mm(ground.bound_m));
          if (ground.has_ceiling) add(view.ground(ex, ey, ground.ceiling_m), column.surface[1]);
        }
      }
      columns_[map_.index(x, y)] = column;
    }
  }
}

void GroundTerrain::judge(const GroundStance& stance, std::int32_t x0, std::int32_t y0, std::int32_t x1,
                          std::int32_t y1) {
  for (std::int32_t y = y0; y <= y1; ++y) {
    for (std::int32_t x = x0; x <= x1; ++x) {
      const std::size_t at = map_.index(x, y);
      std::uint8_t rough = 0;
      GroundCell cell = judge_cell(x, y, rough);
      std::int16_t height_mm = 0;
      const GroundCell stood{{0, 0}, {GroundState::carries, GroundState::unknown}};
      if (is_under(stance, x, y, 0.0, height_mm) ||
          (cell.is_unknown() && is_under(stance, x, y, 1e-3 * lattice_.cell_mm, height_mm) &&
           !is_hole(columns_[at], height_mm))) {
        cell = stood;
        cell.height_mm[0] = height_mm;
      } else if (cell.is_unknown()) {
        const std::int16_t trusted_mm = to_mm(trusted_.p_m.z);
        if (is_trusted(x, y) && !is_hole(columns_[at], trusted_mm)) {
          cell = stood;
          cell.height_mm[0] = trusted_mm;
        } else if (!fill_gap(x, y, cell) && is_hopeless(low_[0] + x, low_[1] + y)) {
          cell.state[0] = GroundState::blocked;
        }
      }
      newest_[at] = cell;
      rough_[at] = rough;
    }
  }
}

GroundCell GroundTerrain::judge_cell(std::int32_t x, std::int32_t y, std::uint8_t& rough) const {
  static constexpr std::int32_t kBeside[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  GroundCell cell;
  const Column& mine = columns_[map_.index(x, y)];
  std::int32_t worst_mm = 0;
  for (std::int32_t s = 0; s < 2; ++s) {
    const Surface& surface = mine.surface[s];
    if (surface.known == 0) continue;
    std::int32_t step_mm = surface.high_mm - surface.low_mm;
    bool blocked = step_mm > step_mm_;
    for (const auto& beside : kBeside) {
      if (!map_.is_inside(x + beside[0], y + beside[1])) continue;
      const Column& other = columns_[map_.index(x + beside[0], y + beside[1])];
      std::int32_t nearest_mm = INT32_MAX;  // signed: how much lower the other one is
      for (const Surface& its : other.surface) {
        if (its.known == 0) continue;
        const std::int32_t down_mm = surface.high_mm - its.high_mm;
        if (nearest_mm == INT32_MAX || mm_size(down_mm) < mm_size(nearest_mm)) nearest_mm = down_mm;
      }
      if (nearest_mm == INT32_MAX) {
        // A hole beside: what carries ends here, and nobody knows how far in front of the edge.
        if (other.bound_mm != INT16_MAX && surface.high_mm - other.bound_mm > step_mm_) blocked = true;
        continue;
      }
      if (nearest_mm > step_mm_) blocked = true;
      step_mm = std::max(step_mm, mm_size(nearest_mm));
    }
    cell.height_mm[s] = surface.high_mm;
    cell.state[s] = blocked ? GroundState::blocked : GroundState::carries;
    worst_mm = std::max(worst_mm, step_mm);
  }
  const std::int32_t parts = worst_mm * kRoughClasses / std::max(step_mm_, 1);
  rough = static_cast<std::uint8_t>(std::min<std::int32_t>(parts, kRoughClasses));
  return cell;
}

// A gap of at most two cells along both axes and both diagonals, between ground of one height: of whichever
// surface is known.
bool GroundTerrain::fill_gap(std::int32_t x, std::int32_t y, GroundCell& cell) const {
  static constexpr std::int32_t kAxes[4][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}};
  std::int32_t low_mm = INT32_MAX;
  std::int32_t high_mm = INT32_MIN;
  if (cell.state[0] != GroundState::unknown) return false;
  for (const auto& axis : kAxes) {
    std::int32_t gap = -1;
    for (const std::int32_t side : {-1, 1}) {
      bool found = false;
      for (std::int32_t k = 1; k <= kMostGap && !found; ++k) {
        const std::int32_t ox = x + side * k * axis[0];
        const std::int32_t oy = y + side * k * axis[1];
        if (!map_.is_inside(ox, oy)) break;
        const Column& other = columns_[map_.index(ox, oy)];
        for (const Surface& its : other.surface) {
          if (its.known == 0) continue;
          low_mm = std::min<std::int32_t>(low_mm, its.low_mm);
          high_mm = std::max<std::int32_t>(high_mm, its.high_mm);
          found = true;
        }
        if (found) gap += k;
      }
      if (!found) return false;
    }
    if (gap > kMostGap) return false;
  }
  if (high_mm - low_mm > step_mm_ || is_hole(columns_[map_.index(x, y)], low_mm)) return false;
  cell.height_mm[0] = static_cast<std::int16_t>((low_mm + high_mm) / 2);
  cell.state[0] = GroundState::carries;
  return true;
}

// What the robot stands on carries it, whatever a ray may have met there: the robot itself, most likely.
// Beside it, up to the margin, nothing that was seen is put aside.
bool GroundTerrain::is_under(const GroundStance& stance, std::int32_t x, std::int32_t y, double margin_m,
                             std::int16_t& height_mm) const {
  const double dx = middle_m(low_[0] + x) - stance.p_m.x;
  const double dy = middle_m(low_[1] + y) - stance.p_m.y;
  const double along = std::fabs(stance.cos_yaw * dx + stance.sin_yaw * dy);
  const double across = std::fabs(stance.cos_yaw * dy - stance.sin_yaw * dx);
  if (along > 1e-3 * lattice_.half_length_mm + margin_m || across > 1e-3 * lattice_.half_width_mm + margin_m)
    return false;
  height_mm = to_mm(stance.p_m.z + stance.rise_x * dx + stance.rise_y * dy);
  return true;
}

bool GroundTerrain::is_trusted(std::int32_t x, std::int32_t y) const {
  if (!trusted_.is_set) return false;
  const double dx = middle_m(low_[0] + x) - trusted_.p_m.x;
  const double dy = middle_m(low_[1] + y) - trusted_.p_m.y;
  return dx * dx + dy * dy <= rules_.trusted_m * rules_.trusted_m;
}

}  // namespace sortie::planner
