// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/cloud_match.hpp"

#include <algorithm>
#include <bit>
#include <limits>

namespace sortie::mapping {
namespace {

constexpr std::size_t kRegions = 4 * kMostPlanes;

PlaneGrowingMemory growing_memory(std::size_t cells, rt::Arena& arena) {
  cells = std::max<std::size_t>(cells, 1);
  return {arena.make_array<PlaneCellSlot>("plane cells", cells),
          arena.make_array<std::uint32_t>("plane cells", std::bit_ceil(2 * cells)),
          arena.make_array<std::uint64_t>("plane cells", cells),
          arena.make_array<std::uint32_t>("plane cells", cells),
          arena.make_array<PlaneRegion>("plane regions", kRegions)};
}

}  // namespace

CloudMatch::CloudMatch(const CloudRegistrationConfig& config, const SensedCloud& own, const SensedCloud& kept,
                       rt::Arena& arena)
    : own_(own),
      kept_(kept),
      memory_(growing_memory(std::max(own.layer->config().cells, kept.layer->config().cells), arena)),
      registration_(config) {
  if (arena.refused() != 0) return;  // its memory is still being measured
  set_cells(kept_);
  std::uint64_t units = std::numeric_limits<std::uint64_t>::max();
  static_cast<void>(growing_->run(units));
  growing_->planes(kept_planes_);
}

// In the memory of the cloud before.
void CloudMatch::set_cells(const SensedCloud& cloud) {
  std::fill(memory_.cells.begin(), memory_.cells.end(), PlaneCellSlot{});
  std::fill(memory_.table.begin(), memory_.table.end(), 0u);
  std::fill(memory_.regions.begin(), memory_.regions.end(), PlaneRegion{});
  cloud.layer->prepare();
  PlaneGrowingConfig config = growing_config(cloud.sensor);
  config.cell_m = cloud.layer->cell_m();
  config.min_points = std::max(config.min_points, cloud.layer->config().min_points);
  growing_.emplace(config, memory_);
  // There is room for all, and a layer's cells are cells.
  cloud.layer->for_each_plane_cell(
      [this](const PlaneCell& cell) { static_cast<void>(growing_->set_cell(cell)); });
}

void CloudMatch::begin(const PlaneEstimate& estimate) {
  estimate_ = estimate;
  credit_.clear();
  spent_ = 0;
  stage_ = Stage::cells;
}

bool CloudMatch::run(std::uint64_t& units) {
  const std::uint64_t given = units;
  while (works() && step(units)) {
  }
  spent_ += given - units;
  return !works();
}

// False: the units are spent.
bool CloudMatch::step(std::uint64_t& units) {
  switch (stage_) {
    case Stage::cells:
      if (!credit_.pay(kUnitsPerCell * own_.layer->size(), units)) return false;
      set_cells(own_);
      stage_ = Stage::grow;
      return true;
    case Stage::grow:
      if (!grow(units)) return false;
      growing_->planes(own_planes_);
      // Refused: then its result says "none".
      stage_ =
          registration_.begin(own_planes_, *own_.layer, kept_planes_, *kept_.layer, estimate_) == Status::ok
              ? Stage::match
              : Stage::idle;
      if (stage_ == Stage::idle) result_ = registration_.result();
      return true;
    case Stage::match:
      if (!registration_.run(units)) return false;
      result_ = registration_.result();
      stage_ = Stage::idle;
      return true;
    case Stage::idle:
      break;
  }
  return false;
}

bool CloudMatch::grow(std::uint64_t& units) {
  constexpr std::uint64_t kSlice = 16;
  for (;;) {
    if (!credit_.pay(kSlice * kUnitsPerGrowing, units)) return false;
    std::uint64_t cells = kSlice;
    if (growing_->run(cells)) return true;
  }
}

void CloudMatch::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "cloud match")
      .fixed(own_, kept_, memory_, kept_planes_)
      .scratch(growing_, registration_, own_planes_, credit_)
      .by_hand(stage_)
      .state(estimate_, spent_, result_);
  bool working = works();
  archive.value(working);
  if (!archive.is_reading()) return;
  stage_ = Stage::idle;
  if (!working || archive.status() != Status::ok) return;
  // Bounded, whatever the bytes say: a run ends.
  const CloudResult last = result_;
  std::uint64_t units = spent_;
  begin(estimate_);
  const bool ended = run(units);
  result_ = last;
  if (ended) archive.fail(Status::malformed, "a match of clouds that goes on behind its end");
}

}  // namespace sortie::mapping
