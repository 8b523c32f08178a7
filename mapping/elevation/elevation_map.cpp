// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/elevation/elevation_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mapping/elevation/elevation_sensor.hpp"
#include "mapping/elevation/elevation_units.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

namespace {

constexpr double kFarthestCell = 268435456.0;  // 2^28
constexpr double kMostVariance_m2 = 50.0;
// Odd: each step of the chain can be undone.
constexpr std::uint64_t kChain = 0x9e3779b97f4a7c15;

bool within(double value, double least, double most) { return value >= least && value <= most; }

bool is_good(const ElevationConfig& c) {
  return c.size >= 16 && c.size <= 2048 && std::has_single_bit(static_cast<std::uint32_t>(c.size)) &&
         c.cell_mm >= 10 && c.cell_mm <= 1000 && within(c.min_range_m, 0.0, 1000.0) &&
         within(c.max_range_m, c.min_range_m, 1000.0) && within(c.noise_m, 1e-4, 1.0) &&
         within(c.noise_per_m, 0.0, 1.0) && within(c.least_sigma_m, 0.0025, 0.64) &&
         within(c.felt_sigma_m, 0.0025, 0.64) && within(c.join_m, 0.001, 1.0) &&
         within(c.most_join_m, c.join_m, 2.0) && within(c.ray_short_m, 0.0, 100.0) &&
         within(c.bound_reach_m, 0.01, 100.0);
}

std::int32_t height_units(double height_m) {
  return static_cast<std::int32_t>(nearest_unit(height_m * kHeightUnits));
}

// Inverse variance, 1 .. most.
std::uint16_t weight_of(double variance_m2, std::uint16_t most) {
  const double weight = kUnitWeightVariance_m2 / variance_m2;
  if (!(weight > 1.0)) return 1;
  return weight >= most ? most : static_cast<std::uint16_t>(weight + 0.5);
}

std::uint64_t cell_count(const ElevationConfig& config) {
  return static_cast<std::uint64_t>(config.size) * static_cast<std::uint64_t>(config.size);
}

}  // namespace

std::uint64_t ElevationMap::memory_bytes(const ElevationConfig& config) {
  if (!is_good(config)) return 0;
  return cell_count(config) * (sizeof(ElevationCell) + sizeof(std::int32_t) + sizeof(CellEvidence));
}

ElevationMap::ElevationMap(const ElevationConfig& config, rt::Arena& arena) : config_(config) {
  if (!is_good(config)) return;
  const auto count = static_cast<std::size_t>(cell_count(config));
  cells_ = arena.make_array<ElevationCell>("elevation cells", count, 64);
  bounds_ = arena.make_array<std::int32_t>("elevation bounds", count);
  evidence_ = arena.make_array<CellEvidence>("elevation evidence", count);
  usable_ = cells_.size() == count && bounds_.size() == count && evidence_.size() == count;
  if (!usable_) return;
  rule_.join = height_units(config.join_m);
  rule_.most_join = height_units(config.most_join_m);
  rule_.most_weight = weight_of(config.least_sigma_m * config.least_sigma_m, UINT16_MAX);
  cell_units_ = config.cell_mm * (static_cast<std::int32_t>(kGroundUnits) / 1000);
  bound_reach_ = height_units(config.bound_reach_m);
  output_.low_x = output_.low_y = -config.size / 2;
  clear();
}

void ElevationMap::clear() {
  std::fill(cells_.begin(), cells_.end(), ElevationCell{});
  std::fill(bounds_.begin(), bounds_.end(), ElevationView::kNoBound);
  std::fill(evidence_.begin(), evidence_.end(), CellEvidence{});
  output_.known = 0;
}

ElevationView ElevationMap::view() const {
  ElevationView view;
  if (!usable_) return view;
  view.cells = cells_.data();
  view.bounds = bounds_.data();
  view.evidence = evidence_.data();
  view.size = config_.size;
  view.low[0] = output_.low_x;
  view.low[1] = output_.low_y;
  view.cell_units = cell_units_;
  view.level_m = output_.level_m;
  view.variance = variance_;
  return view;
}

Status ElevationMap::centre_on(const rt::Vector3& p_world_m) {
  if (!rt::is_finite(p_world_m)) return Status::not_finite;
  const double farthest_m = kFarthestCell * cell_units_ / kGroundUnits;
  const bool near = std::fabs(p_world_m.x) < farthest_m && std::fabs(p_world_m.y) < farthest_m &&
                    std::fabs(p_world_m.z) < 1e6;
  if (!usable_ || !near) return Status::out_of_range;
  if (!centred_) {
    output_.level_m = unit_below(p_world_m.z);
    centred_ = true;
  }
  if (std::fabs(p_world_m.z - static_cast<double>(output_.level_m)) > kHeightRange_m)
    return Status::out_of_range;
  const ElevationView window = view();
  roll(window.cell_of(p_world_m.x) - config_.size / 2, window.cell_of(p_world_m.y) - config_.size / 2);
  return Status::ok;
}

void ElevationMap::clear_cell(std::uint32_t index) {
  ElevationCell& cell = cells_[index];
  if (cell.weight[0] != 0) --output_.known;
  cell = {};
  bounds_[index] = ElevationView::kNoBound;
  evidence_[index] = {};
}

// Cells stay where they are; those that come in lie where those that leave were.
void ElevationMap::roll(std::int64_t low_x, std::int64_t low_y) {
  const std::int64_t by_x = low_x - output_.low_x;
  const std::int64_t by_y = low_y - output_.low_y;
  if (by_x == 0 && by_y == 0) return;
  const std::int64_t size = config_.size;
  output_.low_x = low_x;
  output_.low_y = low_y;
  ++output_.rolls;
  if (by_x <= -size || by_x >= size || by_y <= -size || by_y >= size) {
    clear();
    return;
  }
  const ElevationView window = view();
  const std::int64_t first_x = by_x > 0 ? low_x + size - by_x : low_x;
  const std::int64_t end_x = by_x > 0 ? low_x + size : low_x - by_x;
  for (std::int64_t y = low_y; y < low_y + size; ++y)
    for (std::int64_t x = first_x; x < end_x; ++x) clear_cell(window.index(x, y));
  const std::int64_t first_y = by_y > 0 ? low_y + size - by_y : low_y;
  const std::int64_t end_y = by_y > 0 ? low_y + size : low_y - by_y;
  for (std::int64_t y = first_y; y < end_y; ++y)
    for (std::int64_t x = low_x; x < low_x + size; ++x) clear_cell(window.index(x, y));
}

Status ElevationMap::add_variance(double variance_m2) {
  if (!std::isfinite(variance_m2)) return Status::not_finite;
  if (variance_m2 < 0.0 || variance_m2 > kMostVariance_m2) return Status::out_of_range;
  const double parts = variance_rest_ + variance_m2 * (kVarianceParts / kUnitWeightVariance_m2);
  const auto whole = static_cast<std::uint32_t>(parts);
  variance_rest_ = parts - whole;
  variance_ += whole;  // modulo 2^32: cells ask for differences
  if (variance_ - all_aged_ >= 1u << 30) {
    for (ElevationCell& cell : cells_) age(cell, variance_);
    all_aged_ = variance_;
  }
  return Status::ok;
}

bool ElevationMap::place(const rt::Vector3& p_world_m, Sensor& sensor) const {
  const double height_m = p_world_m.z - static_cast<double>(output_.level_m);
  const double farthest_m = kFarthestCell * cell_units_ / kGroundUnits;
  if (!(std::fabs(p_world_m.x) < farthest_m) || !(std::fabs(p_world_m.y) < farthest_m) ||
      !(std::fabs(height_m) <= kHeightRange_m)) {
    return false;
  }
  const std::int64_t edge = std::int64_t{config_.size} * cell_units_;
  const std::int64_t u[2] = {nearest_unit(p_world_m.x * kGroundUnits) - output_.low_x * cell_units_,
                             nearest_unit(p_world_m.y * kGroundUnits) - output_.low_y * cell_units_};
  // A cell from the edge at least: a ray that begins on a border may begin in either cell.
  for (const std::int64_t along : u)
    if (along < cell_units_ || along >= edge - cell_units_) return false;
  sensor = {{static_cast<std::int32_t>(u[0]), static_cast<std::int32_t>(u[1])}, height_units(height_m)};
  return true;
}

// As ElevationView::index(), of a place in the window.
std::uint32_t ElevationMap::index_of(const std::int32_t (&along)[2]) const {
  const auto size = static_cast<std::uint32_t>(config_.size);
  const std::uint32_t x =
      static_cast<std::uint32_t>(output_.low_x) + static_cast<std::uint32_t>(along[0] / cell_units_);
  const std::uint32_t y =
      static_cast<std::uint32_t>(output_.low_y) + static_cast<std::uint32_t>(along[1] / cell_units_);
  return (y & (size - 1)) * size + (x & (size - 1));
}

void ElevationMap::take(std::uint32_t index, std::int32_t height, std::uint16_t weight, std::uint8_t flags) {
  ElevationCell& cell = cells_[index];
  if (cell.weight[0] == 0) {
    ++output_.known;
    cell.variance = variance_;
  }
  age(cell, variance_);
  constexpr auto kStands = static_cast<std::int32_t>(0.1 * kHeightUnits);
  if (cell.weight[0] != 0 && height - cell.height[0] > kStands) evidence_[index].add(&CellEvidence::hits);
  const SurfaceChange change = take_height(cell, height, weight, flags, rule_);
  if (change == SurfaceChange::joined) ++output_.joined;
  if (change == SurfaceChange::merged) ++output_.merged;
  const std::uint64_t what = std::uint64_t{index} << 32 | static_cast<std::uint32_t>(height);
  output_.changes = (output_.changes ^ what) * kChain + weight;
}

void ElevationMap::take_return(const Sensor& sensor, const rt::Vector3& way_m) {
  ++output_.returns;
  const double range2 = rt::dot(way_m, way_m);
  if (!std::isfinite(range2)) {
    ++output_.not_finite;
    return;
  }
  if (range2 < config_.min_range_m * config_.min_range_m) {
    ++output_.too_near;
    return;
  }
  if (range2 > config_.max_range_m * config_.max_range_m) {
    ++output_.too_far;
    return;
  }
  const std::int32_t way[2] = {static_cast<std::int32_t>(unit_below(way_m.x * kGroundUnits)),
                               static_cast<std::int32_t>(unit_below(way_m.y * kGroundUnits))};
  if (config_.ray_stride != 0 && ++ray_phase_ >= config_.ray_stride) {
    ray_phase_ = 0;
    if (way_m.z < 0.0) follow_ray(sensor, way, way_m);
  }
  const std::int32_t u[2] = {sensor.along[0] + way[0], sensor.along[1] + way[1]};
  const std::int32_t edge = config_.size * cell_units_;
  const std::int32_t height = sensor.height + height_units(way_m.z);
  constexpr auto kHighest = static_cast<std::int32_t>(kHeightRange_m * kHeightUnits);
  if (u[0] < 0 || u[0] >= edge || u[1] < 0 || u[1] >= edge || height > kHighest || height < -kHighest) {
    ++output_.outside;
    return;
  }
  ++output_.used;
  const double variance_m2 =
      config_.noise_m * config_.noise_m + config_.noise_per_m * config_.noise_per_m * range2;
  take(index_of(u), height, weight_of(variance_m2, rule_.most_weight),
       way_m.z > 0.0 ? kSeenFromBelow : kSeenFromAbove);
}

Status ElevationMap::update(const rt::PointScan& scan, const SensorPose& pose) {
  const bool rotation = std::fabs(rt::squared_norm(pose.q_world_sensor) - 1.0) < 1e-3;
  if (!rt::is_finite(pose.p_world_sensor_m) || !rotation) {
    output_.returns += scan.header.points;
    output_.not_finite += scan.header.points;
    return Status::not_finite;
  }
  if (scan.points == nullptr && scan.header.points > 0) return Status::malformed;
  if (scan.header.stamp_ns < output_.stamp_ns) return Status::time_backwards;
  Sensor sensor;
  if (!usable_ || !place(pose.p_world_sensor_m, sensor)) {
    ++output_.lost;
    return Status::out_of_range;
  }
  output_.stamp_ns = scan.header.stamp_ns;
  const rt::Quaternion q = rt::normalised(pose.q_world_sensor);
  for (std::uint32_t i = 0; i < scan.header.points; ++i) {
    const rt::ScanPoint& point = scan.points[i];
    take_return(sensor, rt::rotate(q, {static_cast<double>(point.x_m), static_cast<double>(point.y_m),
                                       static_cast<double>(point.z_m)}));
  }
  return Status::ok;
}

Status ElevationMap::feel(std::span<const rt::Vector3> places_m) {
  Status status = usable_ ? Status::ok : Status::out_of_range;
  if (!usable_) return status;
  const std::uint16_t weight = weight_of(config_.felt_sigma_m * config_.felt_sigma_m, rule_.most_weight);
  for (const rt::Vector3& p : places_m) {
    Sensor at;
    if (!rt::is_finite(p)) {
      status = Status::not_finite;
      continue;
    }
    if (!place(p, at)) {
      ++output_.lost;
      status = Status::out_of_range;
      continue;
    }
    ++output_.felt;
    take(index_of(at.along), at.height, weight, kFelt);
  }
  return status;
}

}  // namespace sortie::mapping
