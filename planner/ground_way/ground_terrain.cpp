// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_way/ground_terrain.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/elevation/elevation_cell.hpp"
#include "mapping/elevation/elevation_units.hpp"
#include "rt/floor_divide.hpp"

namespace sortie::planner {

namespace {

using Elevation = mapping::GroundState;

constexpr double kNear_m = 2.0;
constexpr std::int32_t kMostGap = 2;          // cells of a hole that no track falls into
constexpr std::int32_t kHeightNoise_mm = 15;  // a known height that moves by less has not changed
constexpr std::uint8_t kRoughClasses = 4;
constexpr std::uint8_t kPriceOfRough = 16;  // as long again at the roughest that carries, twice by tilt

constexpr std::int32_t abs_of(std::int32_t v) { return v < 0 ? -v : v; }

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

GroundTerrain::GroundTerrain(const GroundPathConfig& lattice, const GroundRules& rules,
                             std::int32_t elevation_cell_mm, rt::Arena& arena)
    : lattice_(lattice),
      rules_(rules),
      per_cell_(elevation_cell_mm > 0 ? lattice.cell_mm / elevation_cell_mm : 0),
      step_mm_(static_cast<std::int32_t>(1e3 * rules.most_step_m + 0.5)),
      columns_(arena.make_array<Column>("terrain: heights", GroundMap::cells_for(lattice))),
      newest_(arena.make_array<GroundCell>("terrain: newest", columns_.size())),
      rough_(arena.make_array<std::uint8_t>("terrain: newest", columns_.size())),
      map_rough_(arena.make_array<std::uint8_t>("terrain: planned", columns_.size())),
      map_cells_(arena.make_array<GroundCell>("terrain: planned", columns_.size())),
      map_tiles_(arena.make_array<std::uint64_t>("terrain: planned", GroundMap::tile_words_for(lattice))),
      map_(lattice, map_cells_, map_tiles_) {
  usable_ = check(lattice) == Status::ok && per_cell_ > 0 &&
            per_cell_ * elevation_cell_mm == lattice.cell_mm && map_.nx() == lattice.nx &&
            map_rough_.size() == newest_.size() && !newest_.empty();
}

std::int64_t GroundTerrain::cell_of(double world_m) const {
  return rt::floor_divide(static_cast<std::int64_t>(rt::floor(1e3 * world_m)),
                          static_cast<std::int64_t>(lattice_.cell_mm));
}

std::int16_t GroundTerrain::to_mm(double world_m) const {
  const double mm = 1e3 * (world_m - level_m_);
  return static_cast<std::int16_t>(std::clamp(mm < 0 ? mm - 0.5 : mm + 0.5, -32000.0, 32000.0));
}

bool GroundTerrain::follow(const rt::Vector3& p_m) {
  const std::int64_t x = cell_of(p_m.x);
  const std::int64_t y = cell_of(p_m.y);
  const auto is_near = [](std::int64_t at, std::int64_t low, std::int32_t size) {
    const std::int64_t off = at - low - size / 2;
    return off >= -size / 8 && off <= size / 8;
  };
  if (has_window_ && is_near(x, low_[0], lattice_.nx) && is_near(y, low_[1], lattice_.ny) &&
      std::fabs(p_m.z - level_m_) < 16.0)
    return false;
  has_window_ = true;
  low_[0] = x - lattice_.nx / 2;
  low_[1] = y - lattice_.ny / 2;
  level_m_ = rt::floor(p_m.z);
  std::fill(columns_.begin(), columns_.end(), Column{});
  std::fill(newest_.begin(), newest_.end(), GroundCell{});
  std::fill(rough_.begin(), rough_.end(), std::uint8_t{0});
  next_row_ = 0;
  return true;
}

void GroundTerrain::read(const mapping::ElevationView& view, const GroundStance& stance, bool all) {
  const auto column_of = [&](double m, int axis) {
    return static_cast<std::int32_t>(cell_of(m) - low_[axis]);
  };
  const auto refresh = [&](std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
    x0 = std::max(x0, 0);
    y0 = std::max(y0, 0);
    x1 = std::min(x1, lattice_.nx - 1);
    y1 = std::min(y1, lattice_.ny - 1);
    read_columns(view, stance.p_m.z, x0, y0, x1, y1);
    // What lies beside them is judged by them, too.
    judge(stance, std::max(x0 - kMostGap, 0), std::max(y0 - kMostGap, 0),
          std::min(x1 + kMostGap, lattice_.nx - 1), std::min(y1 + kMostGap, lattice_.ny - 1));
  };
  if (all) {
    refresh(0, 0, lattice_.nx - 1, lattice_.ny - 1);
    return;
  }
  const auto rows = static_cast<std::int32_t>(rules_.rows);
  refresh(0, next_row_, lattice_.nx - 1, next_row_ + rows - 1);
  next_row_ = next_row_ + rows >= lattice_.ny ? 0 : next_row_ + rows;
  refresh(column_of(stance.p_m.x - kNear_m, 0), column_of(stance.p_m.y - kNear_m, 1),
          column_of(stance.p_m.x + kNear_m, 0), column_of(stance.p_m.y + kNear_m, 1));
}

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
      if (is_under(stance, x, y)) {
        cell = GroundCell{{to_mm(stance.p_m.z), 0}, {GroundState::carries, GroundState::unknown}};
      } else if (cell.is_unknown()) {
        if (is_trusted(x, y)) {
          cell.height_mm[0] = to_mm(trusted_.p_m.z);
          cell.state[0] = GroundState::carries;
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
        if (nearest_mm == INT32_MAX || abs_of(down_mm) < abs_of(nearest_mm)) nearest_mm = down_mm;
      }
      if (nearest_mm == INT32_MAX) {
        // A hole beside: what carries ends here, and nobody knows how far in front of the edge.
        if (other.bound_mm != INT16_MAX && surface.high_mm - other.bound_mm > step_mm_) blocked = true;
        continue;
      }
      if (nearest_mm > step_mm_) blocked = true;
      step_mm = std::max(step_mm, abs_of(nearest_mm));
    }
    cell.height_mm[s] = surface.high_mm;
    cell.state[s] = blocked ? GroundState::blocked : GroundState::carries;
    worst_mm = std::max(worst_mm, step_mm);
  }
  const std::int32_t parts = worst_mm * kRoughClasses / std::max(step_mm_, 1);
  rough = static_cast<std::uint8_t>(std::min<std::int32_t>(parts, kRoughClasses));
  return cell;
}

// A gap of at most two cells along both axes, between ground of one height: of whichever surface is known.
bool GroundTerrain::fill_gap(std::int32_t x, std::int32_t y, GroundCell& cell) const {
  static constexpr std::int32_t kAxes[2][2] = {{1, 0}, {0, 1}};
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
  if (high_mm - low_mm > step_mm_) return false;
  cell.height_mm[0] = static_cast<std::int16_t>((low_mm + high_mm) / 2);
  cell.state[0] = GroundState::carries;
  return true;
}

// What the robot stands on carries it, whatever a ray may have met there: the robot itself, most likely.
bool GroundTerrain::is_under(const GroundStance& stance, std::int32_t x, std::int32_t y) const {
  const double cell_m = 1e-3 * lattice_.cell_mm;
  const double dx = middle_m(low_[0] + x) - stance.p_m.x;
  const double dy = middle_m(low_[1] + y) - stance.p_m.y;
  const double along = std::fabs(stance.cos_yaw * dx + stance.sin_yaw * dy);
  const double across = std::fabs(stance.cos_yaw * dy - stance.sin_yaw * dx);
  return along <= 1e-3 * lattice_.half_length_mm + cell_m && across <= 1e-3 * lattice_.half_width_mm + cell_m;
}

bool GroundTerrain::is_trusted(std::int32_t x, std::int32_t y) const {
  if (!trusted_.is_set) return false;
  const double dx = middle_m(low_[0] + x) - trusted_.p_m.x;
  const double dy = middle_m(low_[1] + y) - trusted_.p_m.y;
  return dx * dx + dy * dy <= rules_.trusted_m * rules_.trusted_m;
}

bool GroundTerrain::is_hopeless(std::int64_t x, std::int64_t y) const {
  for (std::uint32_t i = 0; i < hopeless_count_; ++i)
    if (hopeless_[i].x == x && hopeless_[i].y == y) return true;
  return false;
}

void GroundTerrain::give_up(std::int64_t x, std::int64_t y) {
  if (hopeless_count_ < kMostHopeless && !is_hopeless(x, y)) hopeless_[hopeless_count_++] = {x, y};
}

void GroundTerrain::hand_over() {
  for (std::int32_t y = 0; y < lattice_.ny; ++y) {
    for (std::int32_t x = 0; x < lattice_.nx; ++x) {
      const std::size_t at = map_.index(x, y);
      GroundCell cell = newest_[at];
      const GroundCell& old = map_.cell(x, y);
      for (std::int32_t s = 0; s < 2; ++s) {
        if (cell.state[s] != GroundState::unknown && cell.state[s] == old.state[s] &&
            abs_of(cell.height_mm[s] - old.height_mm[s]) <= kHeightNoise_mm)
          cell.height_mm[s] = old.height_mm[s];
      }
      const bool is_rougher = abs_of(rough_[at] - map_rough_[at]) > 1;
      if (is_rougher) {
        map_rough_[at] = rough_[at];
        map_.touch(x, y);
      }
      // Inside, and the states are ours.
      static_cast<void>(map_.set(x, y, cell));
    }
  }
}

// Roughness under the middle and the corners, and the tilt of the plane through the corners.
std::uint8_t GroundTerrain::price(const void* self, const GroundPose& pose) {
  const auto& terrain = *static_cast<const GroundTerrain*>(self);
  const GroundMap& map = terrain.map_;
  const CellStep step = kHeadingSteps[static_cast<std::size_t>(pose.heading)];
  const double length = 65536.0 / static_cast<double>(step_length_q16(pose.heading));
  const double ux = length * step.x;
  const double uy = length * step.y;
  const double ahead = static_cast<double>(terrain.lattice_.half_length_mm) / terrain.lattice_.cell_mm;
  const double aside = static_cast<double>(terrain.lattice_.half_width_mm) / terrain.lattice_.cell_mm;
  const std::int32_t middle_mm = map.cell(pose.x, pose.y).height_mm[pose.surface];
  std::int32_t corner_mm[4]{};
  std::int32_t rough = terrain.map_rough_[map.index(pose.x, pose.y)];
  for (std::uint32_t i = 0; i < 4; ++i) {
    const double a = i < 2 ? ahead : -ahead;
    const double b = i % 2 == 0 ? aside : -aside;
    const auto x = pose.x + static_cast<std::int32_t>(rt::floor(a * ux - b * uy + 0.5));
    const auto y = pose.y + static_cast<std::int32_t>(rt::floor(a * uy + b * ux + 0.5));
    corner_mm[i] = middle_mm;
    if (!map.is_inside(x, y)) continue;
    const GroundCell& cell = map.cell(x, y);
    rough = std::max<std::int32_t>(rough, terrain.map_rough_[map.index(x, y)]);
    if (cell.is_unknown()) continue;
    const std::int32_t s = nearest_surface(cell, middle_mm, terrain.lattice_.reach_mm);
    if (s != kNoSurface) corner_mm[i] = cell.height_mm[s];
  }
  const double along = 0.5 * (corner_mm[0] + corner_mm[1] - corner_mm[2] - corner_mm[3]) /
                       (2.0 * terrain.lattice_.half_length_mm);
  const double across = 0.5 * (corner_mm[0] + corner_mm[2] - corner_mm[1] - corner_mm[3]) /
                        (2.0 * terrain.lattice_.half_width_mm);
  const double most = rt::tan(terrain.rules_.most_tilt_rad);
  const double tilt = std::max(std::fabs(along), std::fabs(across)) / most;
  if (!(tilt <= 1.0)) return kBlockedStand;
  const double paid = kPriceOfRough * (static_cast<double>(rough) / kRoughClasses + 2.0 * tilt * tilt);
  return static_cast<std::uint8_t>(std::min(paid, static_cast<double>(kMostPrice)));
}

void GroundTerrain::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "ground terrain")
      .fixed(lattice_, rules_, per_cell_, step_mm_, usable_)
      .by_hand(columns_, newest_, rough_, map_rough_, map_cells_, map_tiles_, map_)
      .state(has_window_, low_, level_m_, next_row_, trusted_, hopeless_)
      .by_hand(hopeless_count_);
  archive.bounded(hopeless_count_, kMostHopeless);
  const auto cell = [&archive](GroundCell& its) {
    for (std::size_t s = 0; s < 2; ++s) {
      archive.value(its.height_mm[s]);
      archive.value(its.state[s]);
      if (its.state[s] <= GroundState::blocked) continue;
      archive.fail(Status::malformed, "a state that ground has not");
      its.state[s] = GroundState::unknown;
    }
  };
  for (std::int32_t y = 0; y < lattice_.ny; ++y) {
    for (std::int32_t x = 0; x < lattice_.nx; ++x) {
      const std::size_t at = map_.index(x, y);
      for (Surface& surface : columns_[at].surface) {
        archive.value(surface.low_mm);
        archive.value(surface.high_mm);
        archive.value(surface.known);
      }
      archive.value(columns_[at].bound_mm);
      cell(newest_[at]);
      archive.value(rough_[at]);
      archive.value(map_rough_[at]);
      GroundCell planned = map_.cell(x, y);
      cell(planned);
      if (archive.is_reading()) static_cast<void>(map_.set(x, y, planned));
    }
  }
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  const bool is_near =
      low_[0] > -kFarthest && low_[0] < kFarthest && low_[1] > -kFarthest && low_[1] < kFarthest;
  if (archive.is_reading() &&
      !(is_near && std::fabs(level_m_) < 1e6 && next_row_ >= 0 && next_row_ < lattice_.ny)) {
    archive.fail(Status::malformed, "a window that is nowhere");
    low_[0] = low_[1] = next_row_ = 0;
    level_m_ = 0.0;
  }
}

}  // namespace sortie::planner
