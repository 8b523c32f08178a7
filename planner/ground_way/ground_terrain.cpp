// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ground_way/ground_terrain.hpp"

#include <algorithm>
#include <cmath>

#include "rt/floor_divide.hpp"

namespace sortie::planner {

namespace {

constexpr double kNear_m = 2.0;
constexpr std::int32_t kHeightNoise_mm = 15;  // a known height that moves by less has not changed
constexpr std::uint8_t kPriceOfRough = 16;    // as long again at the roughest that carries, twice by tilt

constexpr std::int32_t mm_moved(std::int32_t v) { return v < 0 ? -v : v; }

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
            mm_moved(cell.height_mm[s] - old.height_mm[s]) <= kHeightNoise_mm)
          cell.height_mm[s] = old.height_mm[s];
      }
      const bool is_rougher = mm_moved(rough_[at] - map_rough_[at]) > 1;
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
      !(is_near && std::fabs(level_m_) < 1e6 && rt::is_finite(trusted_.p_m) &&
        std::fabs(trusted_.p_m.z) < 1e6 && next_row_ >= 0 && next_row_ < lattice_.ny)) {
    archive.fail(Status::malformed, "a window that is nowhere");
    low_[0] = low_[1] = next_row_ = 0;
    trusted_ = {};
    level_m_ = 0.0;
  }
}

}  // namespace sortie::planner
