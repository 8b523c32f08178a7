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

/// Of a layer for `grids`, which no point is put into; where there are none it has next to no memory.
SightConfig twice_as_wide(SightConfig config, std::uint32_t grids) {
  config.cell_m *= 2.0;
  config.points = 1;
  if (grids == 0) config.cells = config.window_cells = config.window_cells_up = 1;
  return config;
}

}  // namespace

CloudMatch::CloudMatch(const CloudMatchConfig& config, const SensedCloud& own, const SensedCloud& kept,
                       rt::Arena& arena)
    : config_(config),
      own_(own),
      kept_(kept),
      wide_(twice_as_wide(finer().layer->config(), config.grids), arena),
      memory_(growing_memory(std::max(own.layer->config().cells, kept.layer->config().cells), arena)),
      registration_(config.registration) {
  if (arena.refused() != 0) return;  // its memory is still being measured
  const std::span<const SurfelIndex> cells = kept_.layer->begin_cells();
  kept_.layer->make_cells(cells);
  if (!own_is_finer()) finest_ = cells;  // it stays as it is
  clear_planes(kept_);
  set_cells(*kept_.layer, cells);
  std::uint64_t units = std::numeric_limits<std::uint64_t>::max();
  static_cast<void>(growing_->run(units));
  growing_->planes(kept_planes_);
}

// In the memory of the cloud before.
void CloudMatch::clear_planes(const SensedCloud& cloud) {
  std::fill(memory_.cells.begin(), memory_.cells.end(), PlaneCellSlot{});
  std::fill(memory_.table.begin(), memory_.table.end(), 0u);
  std::fill(memory_.regions.begin(), memory_.regions.end(), PlaneRegion{});
  PlaneGrowingConfig config = growing_config(cloud.sensor);
  config.cell_m = cloud.layer->cell_m();
  config.min_points = std::max(config.min_points, cloud.layer->config().min_points);
  growing_.emplace(config, memory_);
}

void CloudMatch::set_cells(const SightLayer& layer, std::span<const SurfelIndex> some) {
  // There is room for all, and a layer's cells are cells.
  layer.for_each_plane_cell(some,
                            [this](const PlaneCell& cell) { static_cast<void>(growing_->set_cell(cell)); });
}

void CloudMatch::begin(const PlaneEstimate& estimate) {
  estimate_ = estimate;
  credit_.clear();
  spent_ = 0;
  grid_ = 0;
  next_ = 0;
  stage_ = Stage::sort;
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
    case Stage::clear:
      if (!credit_.pay(kUnitsPerCleared * wide_.config().cells, units)) return false;
      wide_.clear();
      moved_m_ = widen({});
      cells_ = finest_;
      stage_ = Stage::widen;
      return true;
    case Stage::widen:
      if (!pass(kUnitsPerWidened, units, [this](auto some) { static_cast<void>(widen(some)); })) return false;
      stage_ = Stage::sort;
      return true;
    case Stage::sort:
      if (!credit_.pay(kUnitsPerSorted * made().size(), units)) return false;
      cells_ = made().begin_cells();
      if (grid_ == 0 && own_is_finer()) finest_ = cells_;
      stage_ = Stage::cells;
      return true;
    case Stage::cells:
      if (!pass(kUnitsPerCell, units, [this](auto some) { made().make_cells(some); })) return false;
      stage_ = Stage::memory;
      return true;
    case Stage::memory:
      if (!credit_.pay(kUnitsPerCleared * memory_.cells.size(), units)) return false;
      clear_planes(grid_ == 0 ? own_ : SensedCloud{&wide_, finer().sensor});
      stage_ = Stage::planes;
      return true;
    case Stage::planes:
      if (!pass(kUnitsPerPlaneCell, units, [this](auto some) { set_cells(made(), some); })) return false;
      stage_ = Stage::grow;
      return true;
    case Stage::grow:
      if (!grow(units)) return false;
      growing_->planes(grid_ == 0 ? own_planes_ : wide_planes_);
      stage_ = Stage::match;
      if (!begin_match()) end_match();  // its result says "none"
      return true;
    case Stage::match:
      if (!registration_.run(units)) return false;
      end_match();
      return true;
    case Stage::idle:
      break;
  }
  return false;
}

/// Gives `take` cells_, some at a time. False: the units are spent.
template <class F>
bool CloudMatch::pass(std::uint64_t cost, std::uint64_t& units, F&& take) {
  constexpr std::size_t kSlice = 16;
  while (next_ < cells_.size()) {
    const std::size_t count = std::min(kSlice, cells_.size() - next_);
    if (!credit_.pay(cost * count, units)) return false;
    take(cells_.subspan(next_, count));
    next_ += count;
  }
  next_ = 0;
  return true;
}

rt::Vector3 CloudMatch::widen(std::span<const SurfelIndex> some) {
  // Grid after grid as different as may be: not aside, half a cell along each axis, then along one, two, one,
  // ...
  constexpr std::uint32_t kAside[CloudMatchConfig::kMostGrids] = {0, 7, 1, 6, 2, 5, 4, 3};
  const auto first = [k = kAside[grid_ - 1]](int axis) { return -static_cast<std::int32_t>(k >> axis & 1u); };
  return wide_.widen(*finer().layer, some, {first(0), first(1), first(2)});
}

/// Of the finer cloud's frame moved by moved_m_ `times`.
PlanePose CloudMatch::moved(const PlanePose& pose, double times) const {
  PlanePose out = pose;
  const rt::Vector3 by = own_is_finer() ? -pose.scale * rt::rotate(pose.q_target_source, moved_m_) : moved_m_;
  out.p_target_source_m = out.p_target_source_m + times * by;
  return out;
}

bool CloudMatch::begin_match() {
  if (grid_ == 0)
    return registration_.begin(own_planes_, *own_.layer, kept_planes_, *kept_.layer, estimate_) == Status::ok;
  PlaneEstimate estimate = estimate_;
  estimate.T_target_source = moved(estimate.T_target_source, 1.0);
  return (own_is_finer()
              ? registration_.begin(wide_planes_, wide_, kept_planes_, *kept_.layer, estimate)
              : registration_.begin(own_planes_, *own_.layer, wide_planes_, wide_, estimate)) == Status::ok;
}

/// One grid has answered: two that agree end it, or the last one.
void CloudMatch::end_match() {
  CloudResult& found = found_[grid_];
  found = registration_.result();
  if (grid_ == 0) {
    middle_m_ = registration_.middle_m();
  } else {
    found.T_target_source = moved(found.T_target_source, -1.0);
    found.T_rival = moved(found.T_rival, -1.0);
    found.units += found_[grid_ - 1].units;
  }
  const CloudResult* best = grid_ > 0 || config_.grids > 0 ? nullptr : &found;
  for (std::uint32_t k = 0; k < grid_; ++k) {
    // No place is known better than two grids agree on it.
    if (!same_place(found_[k].T_target_source, found.T_target_source, middle_m_,
                    config_.registration.most_sigma_m, 2.0 * config_.registration.most_sigma_rad))
      continue;
    // Where cells of a hall say what is turned by half, they do on every grid: only planes know better.
    if (!estimate_.has_yaw() && !(found_[k].placed() && found.placed())) continue;
    for (const CloudResult* one : {&found_[k], &found}) {
      if (one->placed() && (best == nullptr || one->sigma_m < best->sigma_m)) best = one;
    }
  }
  // Clouds that nothing can be made of in their own cells are not asked about again.
  const bool ends = best != nullptr || grid_ == config_.grids || found_[0].verdict == CloudVerdict::none;
  if (!ends) {
    ++grid_;
    stage_ = Stage::clear;
    return;
  }
  stage_ = Stage::idle;
  result_ = best != nullptr ? *best : found_[0];
  result_.units = found.units;
  if (best != nullptr || !result_.placed()) return;
  result_.verdict = CloudVerdict::refused;
  result_.refusal = CloudRefusal::alone;
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
      .fixed(config_, own_, kept_, memory_, kept_planes_)
      .scratch(wide_, growing_, registration_, own_planes_, wide_planes_, credit_, grid_, moved_m_, middle_m_,
               finest_, cells_, next_, found_)
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
