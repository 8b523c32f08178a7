// SPDX-License-Identifier: BSD-3-Clause
// Cells and regions: what is kept, and how a cell comes and goes. The steps are in plane_growing_steps.cpp
// and plane_growing_merge.cpp.
#include "mapping/registration/plane_growing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "mapping/grid/mix64.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
constexpr std::int32_t kLimit = 1 << 19;

std::uint64_t key_of(const std::int32_t (&at)[3]) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) key = key << 20 | static_cast<std::uint32_t>(at[i] + kLimit);
  return key;
}

std::uint8_t grade_of(const PlaneCell& cell) {
  const double variance = static_cast<double>(cell.variance_m2[0]);
  const int thick = variance < 1e-4 ? 0 : variance < 4e-4 ? 1 : 2;
  return static_cast<std::uint8_t>(2 * thick + (cell.count < 16 ? 1 : 0));
}

Status check(const PlaneCell& c, double edge_m) {
  bool finite = true;
  for (int i = 0; i < 3; ++i)
    finite =
        finite && std::isfinite(c.mean_m[i]) && std::isfinite(c.normal[i]) && std::isfinite(c.variance_m2[i]);
  if (!finite) return Status::not_finite;
  bool good = true;
  double length = 0.0;
  for (int i = 0; i < 3; ++i) {
    good = good && c.at[i] >= -kLimit && c.at[i] < kLimit;
    good = good && std::fabs(static_cast<double>(c.mean_m[i])) <= edge_m;
    good = good && c.variance_m2[i] >= 0.0f && static_cast<double>(c.variance_m2[i]) <= edge_m * edge_m;
    length += static_cast<double>(c.normal[i]) * static_cast<double>(c.normal[i]);
  }
  good = good && length > 1.0 - 1e-3 && length < 1.0 + 1e-3;
  good =
      good && c.variance_m2[0] <= c.variance_m2[1] * 1.001f && c.variance_m2[1] <= c.variance_m2[2] * 1.001f;
  return good ? Status::ok : Status::out_of_range;
}
}  // namespace

PlaneGrowing::PlaneGrowing(const PlaneGrowingConfig& config, const PlaneGrowingMemory& memory)
    : config_(config),
      memory_(memory),
      least_cosine_(rt::cos(config.most_angle_rad)),
      merge_cosine_(rt::cos(config.merge_angle_rad)) {
  config_.most_weight = std::clamp(config_.most_weight, 1u, kPlaneWeight);
  const auto cells = static_cast<std::uint32_t>(memory_.cells.size());
  for (std::uint32_t i = 0; i < cells; ++i) memory_.cells[i].next = i + 2 <= cells ? i + 2 : 0;
  free_ = cells > 0 ? 1 : 0;
}

// ---- Cells by their place. Slots are counted from 1. ----

std::uint32_t PlaneGrowing::find(const std::int32_t (&at)[3]) const {
  const auto mask = static_cast<std::uint32_t>(memory_.table.size() - 1);
  for (auto entry = static_cast<std::uint32_t>(mix64(key_of(at))) & mask;; entry = (entry + 1) & mask) {
    const std::uint32_t slot = memory_.table[entry];
    if (slot == 0) return 0;
    const PlaneCellSlot& cell = memory_.cells[slot - 1];
    if (cell.at[0] == at[0] && cell.at[1] == at[1] && cell.at[2] == at[2]) return slot;
  }
}

std::uint32_t PlaneGrowing::insert(const std::int32_t (&at)[3]) {
  if (free_ == 0) return 0;
  const std::uint32_t slot = free_;
  PlaneCellSlot& cell = memory_.cells[slot - 1];
  free_ = cell.next;
  cell = {};
  cell.used = 1;
  for (int i = 0; i < 3; ++i) cell.at[i] = at[i];
  const auto mask = static_cast<std::uint32_t>(memory_.table.size() - 1);
  auto entry = static_cast<std::uint32_t>(mix64(key_of(at))) & mask;
  while (memory_.table[entry] != 0) entry = (entry + 1) & mask;
  memory_.table[entry] = slot;
  ++used_;
  return slot;
}

/// Entries behind the one that goes move up, so that no search ends early.
void PlaneGrowing::erase(std::uint32_t slot) {
  const auto mask = static_cast<std::uint32_t>(memory_.table.size() - 1);
  const auto home = [&](std::uint32_t s) {
    return static_cast<std::uint32_t>(mix64(key_of(memory_.cells[s - 1].at))) & mask;
  };
  std::uint32_t hole = home(slot);
  while (memory_.table[hole] != slot) hole = (hole + 1) & mask;
  for (std::uint32_t entry = (hole + 1) & mask; memory_.table[entry] != 0; entry = (entry + 1) & mask) {
    const std::uint32_t wanted = home(memory_.table[entry]);
    if (((entry - wanted) & mask) < ((entry - hole) & mask)) continue;  // it would lie before its home
    memory_.table[hole] = memory_.table[entry];
    hole = entry;
  }
  memory_.table[hole] = 0;
  PlaneCellSlot& cell = memory_.cells[slot - 1];
  cell = {};
  cell.next = free_;
  free_ = slot;
  --used_;
}

// ---- The heap of cells that wait to be seeds: grade first, then place. ----

void PlaneGrowing::push(std::uint32_t slot) {
  PlaneCellSlot& cell = memory_.cells[slot - 1];
  if (cell.waiting != 0 || heap_size_ == memory_.heap.size()) return;
  cell.waiting = 1;
  memory_.heap[heap_size_++] = std::uint64_t{cell.grade} << 60 | key_of(cell.at);
  std::push_heap(memory_.heap.data(), memory_.heap.data() + heap_size_, std::greater<>());
}

/// The next one's slot, or 0 where it has gone meanwhile.
std::uint32_t PlaneGrowing::pop() {
  std::pop_heap(memory_.heap.data(), memory_.heap.data() + heap_size_, std::greater<>());
  const std::uint64_t least = memory_.heap[--heap_size_];
  std::int32_t place[3];
  for (int i = 0; i < 3; ++i)
    place[i] = static_cast<std::int32_t>(least >> (20 * (2 - i)) & 0xfffff) - kLimit;
  const std::uint32_t slot = find(place);
  if (slot != 0) memory_.cells[slot - 1].waiting = 0;
  return slot;
}

// ---- Cells and their regions. ----

/// Sums about a cell as sums about a region's anchor.
PlaneSums PlaneGrowing::relative(PlaneSums sums, const std::int32_t (&at)[3], const PlaneRegion& region) {
  std::int64_t d[3];
  for (int i = 0; i < 3; ++i) d[i] = std::int64_t{at[i] - region.anchor[i]} * kPlaneSteps;
  sums.shift(d);
  return sums;
}

void PlaneGrowing::put_in(std::uint32_t slot, std::uint16_t number) {
  PlaneCellSlot& cell = memory_.cells[slot - 1];
  PlaneRegion& region = memory_.regions[number - 1u];
  cell.region = number;
  cell.before = 0;
  cell.next = region.first;
  if (region.first != 0) memory_.cells[region.first - 1].before = slot;
  region.first = slot;
  ++region.cells;
  region.sums.add(relative(cell.sums, cell.at, region));
  region.changed = true;
}

void PlaneGrowing::take_out(std::uint32_t slot) {
  PlaneCellSlot& cell = memory_.cells[slot - 1];
  if (cell.region == 0) return;
  PlaneRegion& region = memory_.regions[cell.region - 1u];
  if (cell.before != 0)
    memory_.cells[cell.before - 1].next = cell.next;
  else
    region.first = cell.next;
  if (cell.next != 0) memory_.cells[cell.next - 1].before = cell.before;
  region.sums.add(relative(cell.sums, cell.at, region), -1);
  region.changed = true;
  if (--region.cells == 0) region = {};
  cell.region = 0;
  cell.next = cell.before = 0;
}

Status PlaneGrowing::set_cell(const PlaneCell& cell) {
  const Status status = check(cell, config_.cell_m);
  if (cell.count > 0 && status != Status::ok) return status;
  for (const std::int32_t at : cell.at) {
    if (at < -kLimit || at >= kLimit) return Status::out_of_range;
  }
  std::uint32_t slot = find(cell.at);
  if (slot == 0 && cell.count == 0) return Status::ok;
  if (slot == 0) slot = insert(cell.at);
  if (slot == 0) {
    ++counts_.cells_full;
    return Status::full;
  }
  take_out(slot);
  if (stage_ == Stage::done || stage_ == Stage::finish || stage_ == Stage::merge) stage_ = Stage::seed;
  if (cell.count == 0) {
    erase(slot);
    return Status::ok;
  }
  PlaneCellSlot& kept = memory_.cells[slot - 1];
  const double length = std::sqrt(static_cast<double>(cell.normal[0]) * static_cast<double>(cell.normal[0]) +
                                  static_cast<double>(cell.normal[1]) * static_cast<double>(cell.normal[1]) +
                                  static_cast<double>(cell.normal[2]) * static_cast<double>(cell.normal[2]));
  for (int i = 0; i < 3; ++i) {
    kept.normal[i] = static_cast<float>(static_cast<double>(cell.normal[i]) / length);
    kept.mean_m[i] = (cell.at[i] + 0.5) * config_.cell_m + static_cast<double>(cell.mean_m[i]);
  }
  kept.sums = sums_of(cell, config_.cell_m, config_.most_weight);
  const double thin = config_.most_thickness_m * config_.most_thickness_m;
  const double least = static_cast<double>(cell.variance_m2[0]);
  kept.flat = cell.count >= config_.min_points && least <= thin &&
              least <= config_.most_flatness * static_cast<double>(cell.variance_m2[1]);
  kept.released = 0;
  if (kept.waiting == 0) kept.grade = grade_of(cell);
  if (kept.flat != 0) push(slot);
  return Status::ok;
}

std::uint32_t PlaneGrowing::regions() const {
  std::uint32_t count = 0;
  for (const PlaneRegion& region : memory_.regions) count += region.cells > 0 ? 1u : 0u;
  return count;
}

std::uint32_t PlaneGrowing::planes(PlaneSet& out) const {
  std::uint32_t left_out = 0;
  const auto larger = [](const Plane& a, const Plane& b) {
    return a.area_m2 != b.area_m2 ? a.area_m2 > b.area_m2 : a.id < b.id;
  };
  out.clear();
  for (std::uint32_t i = 0; i < regions_end_; ++i) {
    const PlaneRegion& region = memory_.regions[i];
    if (region.cells < config_.min_cells || region.changed) continue;
    if (out.full()) {
      ++left_out;
      if (!larger(region.shape, out.back())) continue;
      out.pop_back();
    }
    (void)out.push_back(region.shape);
    for (std::uint32_t k = out.size() - 1; k > 0 && larger(out[k], out[k - 1]); --k)
      std::swap(out[k], out[k - 1]);
  }
  return left_out;
}

}  // namespace sortie::mapping
