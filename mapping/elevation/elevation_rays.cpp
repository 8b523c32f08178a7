// SPDX-License-Identifier: BSD-3-Clause
// Upper bounds from rays that pass over cells, and the bytes of the map.
#include <algorithm>

#include "mapping/elevation/elevation_map.hpp"
#include "mapping/elevation/elevation_sensor.hpp"
#include "mapping/elevation/elevation_units.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {

namespace {

constexpr std::uint64_t kBoundChain = 0x9e3779b97f4a7c15;
constexpr std::int64_t kFarthest = 1 << 29;  // cells of a window that is read, and metres of its level
constexpr double kHeightParts = 65536.0;     // of a height unit, while a ray is followed

// One axis of a ray. Lengths are half units, so that the way to a return, which lies in the middle of a unit,
// is whole and never zero: no ray runs along a border, and a mirrored ray passes the mirrored cells.
struct RayAxis {
  std::int64_t way;      // to the return, > 0
  std::int64_t first;    // to the first border, 1 .. edge
  std::int64_t crossed;  // borders before the end
  std::int64_t inside;   // borders that may be crossed within the window
  std::int32_t cell;     // in which the ray begins
  std::int32_t step;     // 1 or -1
};

RayAxis make_axis(std::int32_t from, std::int32_t way, double share, std::int64_t edge, std::int32_t size) {
  RayAxis axis;
  const std::int64_t start = 2 * std::int64_t{from};
  const std::int64_t to = 2 * std::int64_t{way} + 1;
  if (to > 0) {
    axis.cell = static_cast<std::int32_t>(start / edge);
    axis.first = (axis.cell + 1) * edge - start;
    axis.inside = size - 1 - axis.cell;
    axis.way = to;
    axis.step = 1;
  } else {
    axis.cell = static_cast<std::int32_t>((start + edge - 1) / edge) - 1;
    axis.first = start - axis.cell * edge;
    axis.inside = axis.cell;
    axis.way = -to;
    axis.step = -1;
  }
  const double before = share * static_cast<double>(axis.way) - static_cast<double>(axis.first);
  const double borders = before / static_cast<double>(edge);
  axis.crossed = before > 0.0 ? static_cast<std::int64_t>(borders) + 1 : 0;
  return axis;
}

// The ray leaves the window through a border of `a`: borders of `b` before that.
void stop_at_edge(RayAxis& a, RayAxis& b, std::int64_t edge) {
  if (a.crossed <= a.inside) return;
  a.crossed = a.inside;
  const std::int64_t before = (a.first + a.inside * edge) * b.way - b.first * a.way;
  b.crossed = std::min(b.crossed, before > 0 ? (before - 1) / (edge * a.way) + 1 : 0);
}

}  // namespace

// Each cell that the ray crosses whole before its end is bounded by the height at which the ray came in: the
// ray goes down, so the ground along its way there is nowhere higher.
void ElevationMap::follow_ray(const Sensor& sensor, const std::int32_t (&way)[2], const rt::Vector3& way_m) {
  const double along_m = rt::hypot(way_m.x, way_m.y);
  double share = 1.0 - config_.ray_short_m / along_m;
  if (!(share > 0.0)) return;
  share = std::min(share, config_.bound_reach_m / -way_m.z);
  const std::int64_t edge = 2 * std::int64_t{cell_units_};
  RayAxis x = make_axis(sensor.along[0], way[0], share, edge, config_.size);
  RayAxis y = make_axis(sensor.along[1], way[1], share, edge, config_.size);
  stop_at_edge(x, y, edge);
  stop_at_edge(y, x, edge);

  const double drop = way_m.z * kHeightUnits * kHeightParts;
  const double drop_x = drop / static_cast<double>(x.way);
  const double drop_y = drop / static_cast<double>(y.way);
  const std::int64_t base = std::int64_t{sensor.height} * static_cast<std::int64_t>(kHeightParts);
  std::int64_t height = base;
  std::int64_t next_x = base + static_cast<std::int64_t>(drop_x * static_cast<double>(x.first));
  std::int64_t next_y = base + static_cast<std::int64_t>(drop_y * static_cast<double>(y.first));
  const auto step_x = static_cast<std::int64_t>(drop_x * static_cast<double>(edge));
  const auto step_y = static_cast<std::int64_t>(drop_y * static_cast<double>(edge));
  // Below zero: the next border is one of x.
  std::int64_t order = x.first * y.way - y.first * x.way;
  const std::int64_t order_x = edge * y.way;
  const std::int64_t order_y = edge * x.way;

  const std::uint32_t mask = static_cast<std::uint32_t>(config_.size) - 1;
  const auto size = static_cast<std::uint32_t>(config_.size);
  std::uint32_t column = static_cast<std::uint32_t>(output_.low_x + x.cell) & mask;
  std::uint32_t row = static_cast<std::uint32_t>(output_.low_y + y.cell) & mask;
  const std::uint32_t floor = static_cast<std::uint32_t>(sensor.height - bound_reach_);
  // Whatever stands on the ground is met by rays that are as close to it as this before they end there.
  constexpr auto kLow = static_cast<std::int32_t>(0.3 * kHeightUnits);
  const std::int32_t low =
      sensor.height + static_cast<std::int32_t>(nearest_unit(way_m.z * kHeightUnits)) + kLow;
  std::uint64_t lowered = 0;
  std::uint64_t changes = output_.changes;
  const std::int64_t crossed = x.crossed + y.crossed;
  for (std::int64_t left = crossed; left > 0; --left) {
    const std::uint32_t index = row * size + column;
    const auto bound = static_cast<std::uint32_t>(bounds_[index]);
    const auto now = static_cast<std::uint32_t>(height >> 16);
    // Modulo 2^32: a bound below the ray's reach is one of another level, and gives way as none does.
    if (bound - floor > now - floor) {
      bounds_[index] = static_cast<std::int32_t>(now);
      changes = (changes ^ (std::uint64_t{index} << 32 | now)) * kBoundChain;
      ++lowered;
    }
    if (static_cast<std::int32_t>(now) < low) evidence_[index].add(&CellEvidence::passes);
    const bool along_x = order <= 0;
    height = along_x ? next_x : next_y;
    next_x += along_x ? step_x : 0;
    next_y += along_x ? 0 : step_y;
    order += along_x ? order_x : -order_y;
    column = (column + static_cast<std::uint32_t>(along_x ? x.step : 0)) & mask;
    row = (row + static_cast<std::uint32_t>(along_x ? 0 : y.step)) & mask;
  }
  output_.changes = changes;
  output_.passed += static_cast<std::uint64_t>(crossed);
  output_.lowered += lowered;
}

void ElevationMap::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "elevation map")
      .fixed(config_, rule_, cell_units_, bound_reach_, usable_)
      .by_hand(cells_, bounds_, evidence_)
      .state(output_, variance_, all_aged_, variance_rest_, ray_phase_, centred_);
  if (archive.is_reading()) {
    for (std::int64_t* const number : {&output_.low_x, &output_.low_y, &output_.level_m}) {
      if (*number >= -kFarthest && *number <= kFarthest) continue;
      archive.fail(Status::malformed, "a window farther off than any map reaches");
      *number = 0;
    }
  }
  if (archive.is_reading() && !(variance_rest_ >= 0.0 && variance_rest_ < 1.0)) {
    archive.fail(Status::malformed, "a rest of variance that is none");
    variance_rest_ = 0.0;
  }
  archive.expect(cells_.size(), "the map has another size");
  for (ElevationCell& cell : cells_) archive.value(cell);
  for (std::int32_t& bound : bounds_) archive.value(bound);
  for (CellEvidence& evidence : evidence_) {
    archive.value(evidence.hits);
    archive.value(evidence.passes);
    evidence.hits = std::min(evidence.hits, CellEvidence::kMost);
    evidence.passes = std::min(evidence.passes, CellEvidence::kMost);
  }
}

}  // namespace sortie::mapping
