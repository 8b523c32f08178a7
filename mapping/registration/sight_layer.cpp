// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/sight_layer.hpp"

#include <cmath>
#include <limits>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kMemoryPoints = kMostSurfelPoints / 2;
constexpr std::int32_t kPlaneLimit = 1 << 19;  // of PlaneCell::at
constexpr std::uint32_t kNotFlat = std::numeric_limits<std::uint32_t>::max();

/// The normal on the side of a place.
rt::Vector3 turned_to(const rt::Vector3& normal, const rt::Vector3& away) {
  return rt::dot(normal, away) < 0.0 ? -1.0 * normal : normal;
}
}  // namespace

SurfelLayer SightLayer::make_layer(const SightConfig& config, rt::Arena& arena) {
  const unsigned bits_xy = window_bits(config.window_cells);
  const unsigned bits_z = window_bits(config.window_cells_up);
  const SurfelLayerMemory arrays =
      surfel_memory(arena, "sight_window", "sight_surfels", bits_xy, bits_z, config.cells, false);
  return {config.cell_m, bits_xy, bits_z, config.min_points, kMemoryPoints, arrays};
}

SightLayer::SightLayer(const SightConfig& config, rt::Arena& arena)
    : config_(config),
      layer_(make_layer(config, arena)),
      from_(arena.make_array<rt::Vector3>("sight_places", config.cells)),
      flat_of_(arena.make_array<std::uint32_t>("sight_cells", config.cells)),
      flat_(arena.make_array<SightCell>("sight_cells", config.cells)),
      scratch_(arena.make_array<std::uint64_t>("sight_scratch", config.points)) {}

Status SightLayer::insert(std::span<const rt::Vector3> points_m, const rt::Vector3& from_m) {
  if (!rt::is_finite(from_m)) return Status::not_finite;
  if (points_m.size() > scratch_.size()) return Status::full;
  for (const std::uint64_t surfel : layer_.insert(points_m, from_m, ++views_, scratch_))
    from_[static_cast<SurfelIndex>(surfel)] = from_m;
  return Status::ok;
}

rt::Vector3 SightLayer::widen(const SightLayer& fine, std::span<const SurfelIndex> some,
                              const std::int32_t (&first)[3]) {
  const rt::Vector3 moved = -fine.cell_m() * rt::Vector3{1.0 * first[0], 1.0 * first[1], 1.0 * first[2]};
  for (const SurfelIndex index : some) {
    const SurfelRecord record = fine.layer_.record(index);
    SurfelCell cell = SurfelCell::from_key(record.key);
    bool upper[3];
    for (int i = 0; i < 3; ++i) {
      const std::int32_t at = cell.at[i] - first[i];
      upper[i] = at % 2 != 0;
      cell.at[i] = at >> 1;  // rounds down
    }
    const SurfelIndex surfel = layer_.add(cell, widened(record.sums, upper));
    if (surfel != kNoSurfel) from_[surfel] = fine.from_[index] + moved;
  }
  return moved;
}

std::span<const SurfelIndex> SightLayer::begin_cells() {
  count_ = 0;
  return layer_.by_key();
}

void SightLayer::make_cells(std::span<const SurfelIndex> some) {
  for (const SurfelIndex index : some) {
    flat_of_[index] = kNotFlat;
    const SurfelRecord record = layer_.record(index);
    if (record.sums.count < config_.min_points) continue;
    const Surfel surfel = surfel_of(record.sums, config_.cell_m);
    const double across = surfel.variance(0);
    if (across > config_.most_thickness_m * config_.most_thickness_m ||
        across > config_.most_flatness * surfel.variance(1))
      continue;
    SightCell cell;
    cell.mean_m = layer_.centre_m(SurfelCell::from_key(record.key)) + surfel.mean();
    cell.from_m = from_[index];
    cell.normal = turned_to(surfel.normal(), cell.from_m - cell.mean_m);
    cell.sigma_m = std::sqrt(across / record.sums.count);
    flat_of_[index] = count_;
    flat_[count_++] = cell;
  }
}

bool SightLayer::plane_cell(SurfelIndex index, PlaneCell& out) const {
  const SurfelRecord record = layer_.record(index);
  const SurfelCell at = SurfelCell::from_key(record.key);
  for (int i = 0; i < 3; ++i) {
    if (at.at[i] < -kPlaneLimit || at.at[i] >= kPlaneLimit) return false;
    out.at[i] = at.at[i];
  }
  const Surfel surfel = surfel_of(record.sums, config_.cell_m);
  const rt::Vector3 normal = turned_to(surfel.normal(), from_[index] - (layer_.centre_m(at) + surfel.mean()));
  const double parts[3] = {normal.x, normal.y, normal.z};
  for (int i = 0; i < 3; ++i) {
    out.mean_m[i] = surfel.mean_m[i];
    out.normal[i] = static_cast<float>(parts[i]);
    out.variance_m2[i] = surfel.variance_m2[i];
  }
  out.count = record.sums.count;
  return true;
}

Status SightLayer::put(const SightRecord& record) {
  if (!rt::is_finite(record.from_m)) return Status::malformed;
  const Status status = layer_.put({record.key, record.sums, {}});
  if (status != Status::ok) return status;
  from_[layer_.find(SurfelCell::from_key(record.key))] = record.from_m;
  count_ = 0;
  return Status::ok;
}

void SightLayer::archive(rt::Archive& archive) {
  if (archive.is_reading()) count_ = 0;
  rt::Members(archive, *this, "sight layer")
      .fixed(config_)
      .scratch(flat_of_, flat_, scratch_, count_)
      .by_hand(from_)
      .state(layer_, views_);
  for (const SurfelIndex index : layer_.by_key()) {
    archive.value(from_[index]);
    if (!rt::is_finite(from_[index])) archive.fail(Status::malformed, "a cell that was seen from nowhere");
  }
  if (archive.is_reading() && archive.status() != Status::ok) clear();
}

void SightLayer::clear() {
  layer_.clear();
  count_ = 0;
  views_ = 0;
}

}  // namespace sortie::mapping
