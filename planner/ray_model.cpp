// SPDX-License-Identifier: BSD-3-Clause
#include "planner/ray_model.hpp"

#include "rt/math.hpp"

namespace sortie::planner {

using mapping::VoxelWalk;

RayModel::RayModel(const RayModelConfig& config) : config_(config), cells_{} {
  for (int code = -128; code < 128; ++code) {
    const bool unknown = code == mapping::kUnknownCell;
    const double odds = unknown ? rt::log(config.prior / (1.0 - config.prior)) : code * mapping::kLogOddsStep;
    // Both probabilities from the exponential of a negative number: neither loses digits.
    const double small = rt::exp(odds < 0 ? odds : -odds);
    const double less = small / (1.0 + small);
    const double more = 1.0 / (1.0 + small);
    // -p log p - (1 - p) log(1 - p), with log(1 - p) = -log(1 + e) by its series where e is small.
    const double log1p = small > 1e-4 ? rt::log(1.0 + small) : small * (1.0 - small * (0.5 - small / 3.0));
    const double distance = odds < 0 ? -odds : odds;
    Cell& cell = cells_[mapping::cell_code(static_cast<std::int8_t>(code))];
    cell.occupied = odds < 0 ? less : more;
    cell.passes = odds < 0 ? more : less;
    cell.entropy = less * distance + log1p;
    if (cell.occupied >= config.solid || (unknown && config.unknown == UnknownSpace::stop)) cell.passes = 0.0;
  }
}

namespace {

// A walk whose steps are noted.
struct NotedWalk : VoxelWalk {
  NotedWalk(const VoxelWalk& walk, RayPaths& to) : VoxelWalk(walk), paths(to) {}
  bool step() {
    std::uint32_t axis;
    if (!VoxelWalk::step(axis)) return false;
    paths.put(axis);
    return true;
  }
  RayPaths paths;
};

}  // namespace

template <bool kFresh, bool kCurrent, class Walk>
RayWorth RayModel::stream(Walk& walk, const std::int8_t* cells, const CoverageTable* table) const {
  const double least = config_.least_visible;
  double visible = 1.0;
  double fresh_entropy = 0.0;
  double current_entropy = 0.0;
  RayWorth worth;
  do {
    const Cell& cell = cells_[mapping::cell_code(cells[walk.index])];
    const double ends_here = cell.occupied * visible;
    if constexpr (kFresh) {
      fresh_entropy += cell.entropy;
      worth.fresh += ends_here * fresh_entropy;
    }
    if constexpr (kCurrent) {
      current_entropy += cell.entropy * static_cast<double>(table->left(walk.index));
      worth.current += ends_here * current_entropy;
    }
    visible *= cell.passes;
    ++worth.cells;
  } while (visible >= least && walk.step());
  return worth;
}

RayWorth RayModel::trace(VoxelWalk walk, const std::int8_t* cells, const CoverageTable* table,
                         RayPaths* paths) const {
  const auto along = [&](auto& way) {
    return table != nullptr ? stream<true, true>(way, cells, table) : stream<true, false>(way, cells, table);
  };
  RayWorth worth;
  if (paths != nullptr) {
    NotedWalk noted(walk, *paths);
    worth = along(noted);
    *paths = noted.paths;
  } else {
    worth = along(walk);
  }
  if (table == nullptr) worth.current = worth.fresh;
  return worth;
}

template <class Walk>
RayWorth RayModel::current(Walk walk, const std::int8_t* cells, const CoverageTable& table) const {
  RayWorth worth = stream<false, true>(walk, cells, &table);
  worth.fresh = worth.current;
  return worth;
}
template RayWorth RayModel::current(VoxelWalk, const std::int8_t*, const CoverageTable&) const;
template RayWorth RayModel::current(RayPath, const std::int8_t*, const CoverageTable&) const;

template <class Walk>
bool RayModel::cover(Walk walk, const std::int8_t* cells, CoverageTable& table, std::span<Passed> scratch,
                     RayWorth& worth) const {
  double visible = 1.0;
  double entropy = 0.0;
  worth = {};
  do {
    if (worth.cells >= scratch.size()) return false;
    const Cell& cell = cells_[mapping::cell_code(cells[walk.index])];
    const double ends_here = cell.occupied * visible;
    entropy += cell.entropy * static_cast<double>(table.left(walk.index));
    worth.current += ends_here * entropy;
    scratch[worth.cells] = {walk.index, ends_here};
    visible *= cell.passes;
    ++worth.cells;
  } while (visible >= config_.least_visible && walk.step());
  worth.fresh = worth.current;
  // Lines that it would take, each counted where the ray comes into it.
  std::uint32_t lines = 0;
  std::uint32_t before = UINT32_MAX;
  for (std::uint32_t i = 0; i < worth.cells; ++i) {
    const std::uint32_t line = scratch[i].cell >> CoverageLine::kCellsLog2;
    lines += line != before && !table.has(scratch[i].cell) ? 1 : 0;
    before = line;
  }
  if (!table.has_room(lines)) return false;
  double shown = 0.0;
  for (std::uint32_t i = worth.cells; i-- > 0;) {
    shown += scratch[i].share;
    scratch[i].share = shown;
  }
  for (std::uint32_t i = 0; i < worth.cells; ++i) {
    // A cell that is sure, or seen less than a float can tell, is the same afterwards.
    if (scratch[i].share > 1e-8) table.cover(scratch[i].cell, 1.0 - scratch[i].share);
  }
  return true;
}
template bool RayModel::cover(VoxelWalk, const std::int8_t*, CoverageTable&, std::span<Passed>,
                              RayWorth&) const;
template bool RayModel::cover(RayPath, const std::int8_t*, CoverageTable&, std::span<Passed>,
                              RayWorth&) const;

}  // namespace sortie::planner
