// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/occupancy/occupancy.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mapping/occupancy/voxel_walk.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

namespace {

constexpr double kFarthestCell = 268435456.0;  // 2^28
constexpr std::int32_t kFarthestLow = 1 << 29;
// Odd, so that no two histories that differ in one cell come together again.
constexpr std::uint64_t kChain = 0x9e3779b97f4a7c15;

bool is_probability(double p) { return p > 0.0 && p < 1.0; }

bool is_good(const OccupancyConfig& config, std::size_t cells) {
  for (const std::int32_t n : config.size) {
    if (n < 1 || n > 4096) return false;
  }
  for (const double share : config.anchor) {
    if (!(share >= 0.0 && share < 1.0)) return false;
  }
  const std::uint64_t needed = OccupancyMap::memory_bytes(config);
  return needed <= (1u << 24) && needed <= cells && config.roll_cells >= 1 && config.roll_cells <= 4096 &&
         config.voxel_size_m > 1e-3 && config.voxel_size_m < 100.0 && is_probability(config.prior) &&
         is_probability(config.hit) && is_probability(config.miss) && config.min_range_m >= 0.0 &&
         config.max_range_m > config.min_range_m && std::isfinite(config.max_range_m);
}

}  // namespace

std::uint64_t OccupancyMap::memory_bytes(const OccupancyConfig& config) {
  std::uint64_t bytes = 1;
  for (const std::int32_t n : config.size) bytes *= n > 0 ? static_cast<std::uint64_t>(n) : 0;
  return bytes;
}

int OccupancyMap::code_of(double probability) {
  if (!(probability > 0.0)) return probability == 0.0 ? -kLogOddsLimit : 0;
  if (probability >= 1.0) return kLogOddsLimit;
  const double steps = (rt::log(probability) - rt::log(1.0 - probability)) / kLogOddsStep;
  const double limited = std::clamp(steps, -1.0 * kLogOddsLimit, 1.0 * kLogOddsLimit);
  return static_cast<int>(limited + (limited < 0 ? -0.5 : 0.5));
}

OccupancyMap::OccupancyMap(const OccupancyConfig& config, std::span<std::int8_t> cells)
    : config_(config), usable_(is_good(config, cells.size())) {
  if (!usable_) return;
  cells_ = cells.first(static_cast<std::size_t>(memory_bytes(config)));
  prior_code_ = code_of(config.prior);
  hit_steps_ = code_of(config.hit);
  miss_steps_ = code_of(config.miss);
  output_.low_x = -before_anchor(0);
  output_.low_y = -before_anchor(1);
  output_.low_z = -before_anchor(2);
  clear();
}

void OccupancyMap::clear() {
  std::fill(cells_.begin(), cells_.end(), kUnknownCell);
  output_.known = 0;
}

OccupancyView OccupancyMap::view() const {
  OccupancyView view;
  if (!usable_) return view;
  view.cells = cells_.data();
  std::copy(std::begin(config_.size), std::end(config_.size), view.size);
  view.low[0] = output_.low_x;
  view.low[1] = output_.low_y;
  view.low[2] = output_.low_z;
  view.voxel_size_m = config_.voxel_size_m;
  return view;
}

Status OccupancyMap::centre_on(const rt::Vector3& p_world_m) {
  if (!rt::is_finite(p_world_m)) return Status::not_finite;
  if (!usable_) return Status::out_of_range;
  const double p[3] = {p_world_m.x, p_world_m.y, p_world_m.z};
  const OccupancyView window = view();
  std::int32_t by[3];
  for (int a = 0; a < 3; ++a) {
    const double cell = std::floor(p[a] / config_.voxel_size_m);
    if (!(std::fabs(cell) < kFarthestCell)) return Status::out_of_range;
    const std::int32_t wanted = static_cast<std::int32_t>(cell) - before_anchor(a);
    // Towards zero: the window lags by less than one roll.
    by[a] = (wanted - window.low[a]) / config_.roll_cells * config_.roll_cells;
  }
  if (by[0] != 0 || by[1] != 0 || by[2] != 0) roll(by);
  return Status::ok;
}

// Row by row in the order in which no byte is overwritten before it was read.
void OccupancyMap::roll(const std::int32_t (&by)[3]) {
  const std::int32_t nx = config_.size[0];
  const std::int32_t ny = config_.size[1];
  const std::int32_t nz = config_.size[2];
  const auto row = [&](std::int32_t y, std::int32_t z) {
    return cells_.data() +
           (static_cast<std::size_t>(z) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(nx);
  };
  const std::int32_t kept = std::max(0, nx - std::abs(by[0]));
  for (std::int32_t i = 0; i < nz; ++i) {
    const std::int32_t z = by[2] >= 0 ? i : nz - 1 - i;
    for (std::int32_t j = 0; j < ny; ++j) {
      const std::int32_t y = by[1] >= 0 ? j : ny - 1 - j;
      const std::int32_t from_y = y + by[1];
      const std::int32_t from_z = z + by[2];
      std::int8_t* const to = row(y, z);
      const bool stays = kept > 0 && from_y >= 0 && from_y < ny && from_z >= 0 && from_z < nz;
      if (!stays) {
        std::memset(to, kUnknownCell, static_cast<std::size_t>(nx));
        continue;
      }
      std::memmove(to + std::max(0, -by[0]), row(from_y, from_z) + std::max(0, by[0]),
                   static_cast<std::size_t>(kept));
      std::memset(by[0] >= 0 ? to + kept : to, kUnknownCell, static_cast<std::size_t>(nx - kept));
    }
  }
  output_.low_x += by[0];
  output_.low_y += by[1];
  output_.low_z += by[2];
  ++output_.rolls;
  output_.known = static_cast<std::uint64_t>(cells_.size()) -
                  static_cast<std::uint64_t>(std::count(cells_.begin(), cells_.end(), kUnknownCell));
}

void OccupancyMap::add(std::uint32_t index, int steps, std::uint64_t& changes) {
  std::int8_t& cell = cells_[index];
  const bool unknown = cell == kUnknownCell;
  if (unknown) ++output_.known;
  const int sum = (unknown ? prior_code_ : cell) + steps;
  cell = static_cast<std::int8_t>(std::clamp(sum, -kLogOddsLimit, kLogOddsLimit));
  changes = (changes ^ (std::uint64_t{index} << 8 | cell_code(cell))) * kChain;
}

Status OccupancyMap::update_ray(const rt::Vector3& from, const rt::Vector3& to, bool hit) {
  ++output_.rays;
  const rt::Vector3 way = to - from;
  const double length_m = rt::norm(way);
  if (!std::isfinite(length_m) || !rt::is_finite(from)) {
    ++output_.not_finite;
    return Status::not_finite;
  }
  if (length_m < config_.min_range_m || !(length_m > 0.0)) {
    ++output_.too_near;
    return Status::out_of_range;
  }
  const OccupancyView window = view();
  const rt::Vector3 u = usable_ ? window.to_window(from) : rt::Vector3{};
  if (!usable_ || !window.contains(u)) {
    ++output_.outside;
    return Status::out_of_range;
  }
  ++output_.used;
  const double reach_m = std::min(length_m, config_.max_range_m);
  VoxelWalk walk = make_walk(window, u, (1.0 / length_m) * way, reach_m / config_.voxel_size_m);
  // The cell of the return is asked from its coordinates: a walk may end a hair before its face.
  std::uint32_t last = UINT32_MAX;
  if (const rt::Vector3 v = window.to_window(to);
      hit && length_m <= config_.max_range_m && window.contains(v)) {
    const auto x = static_cast<std::uint32_t>(v.x);
    const auto y = static_cast<std::uint32_t>(v.y);
    const auto z = static_cast<std::uint32_t>(v.z);
    last =
        (z * static_cast<std::uint32_t>(window.size[1]) + y) * static_cast<std::uint32_t>(window.size[0]) + x;
  }
  std::uint64_t changes = output_.changes;  // in a register: a cell's type may alias anything
  do {
    if (walk.index == last) break;
    add(walk.index, miss_steps_, changes);
    ++output_.misses;
  } while (walk.step());
  if (last != UINT32_MAX) {
    add(last, hit_steps_, changes);
    ++output_.hits;
  }
  output_.changes = changes;
  return Status::ok;
}

Status OccupancyMap::update(const rt::PointScan& scan, const SensorPose& pose, std::uint32_t stride) {
  if (stride == 0) return Status::out_of_range;
  const bool rotation = std::fabs(squared_norm(pose.q_world_sensor) - 1.0) < 1e-3;
  if (!rt::is_finite(pose.p_world_sensor_m) || !rotation) {
    const std::uint64_t points = (std::uint64_t{scan.header.points} + stride - 1) / stride;
    output_.rays += points;
    output_.not_finite += points;
    return Status::not_finite;
  }
  if (scan.points == nullptr && scan.header.points > 0) return Status::malformed;
  const rt::Quaternion q = normalised(pose.q_world_sensor);
  for (std::uint64_t i = 0; i < scan.header.points; i += stride) {
    const rt::ScanPoint& point = scan.points[i];
    const rt::Vector3 p{static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                        static_cast<double>(point.z_m)};
    // Counted inside; one bad return does not spoil the scan.
    (void)update_ray(pose.p_world_sensor_m, pose.p_world_sensor_m + rotate(q, p), true);
  }
  return Status::ok;
}

void OccupancyMap::set(std::int32_t x, std::int32_t y, std::int32_t z, int code) {
  const bool inside = usable_ && x >= 0 && x < config_.size[0] && y >= 0 && y < config_.size[1] && z >= 0 &&
                      z < config_.size[2];
  if (!inside) return;
  const std::int32_t index = (z * config_.size[1] + y) * config_.size[0] + x;
  std::int8_t& cell = cells_[static_cast<std::size_t>(index)];
  if (cell == kUnknownCell) ++output_.known;
  cell = static_cast<std::int8_t>(std::clamp(code, -kLogOddsLimit, kLogOddsLimit));
}

void OccupancyMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "occupancy map")
      .fixed(config_, usable_, prior_code_, hit_steps_, miss_steps_)
      .by_hand(cells_)
      .state(output_);
  if (archive.is_reading()) {
    for (std::int32_t* const low : {&output_.low_x, &output_.low_y, &output_.low_z}) {
      if (*low >= -kFarthestLow && *low <= kFarthestLow) continue;
      archive.fail(Status::malformed, "a window farther off than any map reaches");
      *low = 0;
    }
  }
  archive.expect(cells_.size(), "the map has another size");
  for (std::int8_t& cell : cells_) archive.value(cell);
}

}  // namespace sortie::mapping
