// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/sight_layer.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace sortie::mapping {
namespace {
constexpr std::uint32_t kMemoryPoints = kMostSurfelPoints / 2;
constexpr std::uint32_t kNotFlat = std::numeric_limits<std::uint32_t>::max();

unsigned window_bits(std::uint32_t cells) {
  return static_cast<unsigned>(std::bit_width(std::bit_ceil(cells)) - 1);
}
}  // namespace

SurfelLayer SightLayer::make_layer(const SightConfig& config, rt::Arena& arena) {
  const unsigned bits_xy = window_bits(config.window_cells);
  const unsigned bits_z = window_bits(config.window_cells_up);
  const SurfelLayerMemory arrays{
      arena.make_array<SurfelIndex>("sight_window", std::size_t{1} << (2 * bits_xy + bits_z)),
      arena.make_array<std::uint64_t>("sight_surfels", config.cells),
      arena.make_array<SurfelSums>("sight_surfels", config.cells),
      arena.make_array<Surfel>("sight_surfels", config.cells),
      arena.make_array<SurfelIndex>("sight_surfels", config.cells),
      arena.make_array<std::uint32_t>("sight_surfels", config.cells)};
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
  layer_.insert(points_m, ++views_, scratch_);
  SurfelPlace place;
  for (const rt::Vector3& p : points_m) {
    if (!layer_.place(p.x, p.y, p.z, place)) continue;
    const SurfelIndex surfel = layer_.find(place.cell);
    if (surfel != kNoSurfel) from_[surfel] = from_m;
  }
  return Status::ok;
}

void SightLayer::prepare() {
  count_ = 0;
  for (const SurfelIndex index : layer_.by_key()) {
    flat_of_[index] = kNotFlat;
    const SurfelRecord record = layer_.record(index);
    if (record.sums.count < config_.min_points) continue;
    // Of all its points: the layer's own is up to a tenth of them behind.
    const Surfel surfel = surfel_of(record.sums, config_.cell_m);
    const double across = surfel.variance(0);
    if (across > config_.most_thickness_m * config_.most_thickness_m ||
        across > config_.most_flatness * surfel.variance(1))
      continue;
    SightCell cell;
    cell.mean_m = layer_.centre_m(SurfelCell::from_key(record.key)) + surfel.mean();
    cell.from_m = from_[index];
    const rt::Vector3 n = surfel.normal();
    cell.normal = rt::dot(n, cell.from_m - cell.mean_m) < 0.0 ? -1.0 * n : n;
    cell.sigma_m = std::sqrt(across / record.sums.count);
    flat_of_[index] = count_;
    flat_[count_++] = cell;
  }
}

void SightLayer::clear() {
  layer_.clear();
  count_ = 0;
  views_ = 0;
}

}  // namespace sortie::mapping
