// SPDX-License-Identifier: BSD-3-Clause
// The steps of the growing: seed, grow, settle, finish. Merging is in plane_growing_merge.cpp.
#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_growing.hpp"

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

Vector3 normal_of(const PlaneCellSlot& cell) {
  return {static_cast<double>(cell.normal[0]), static_cast<double>(cell.normal[1]),
          static_cast<double>(cell.normal[2])};
}

/// Calls look(place) for the 26 cells around one; stops where it says so.
template <class Look>
void around(const std::int32_t (&at)[3], Look look) {
  for (std::int32_t x = -1; x <= 1; ++x) {
    for (std::int32_t y = -1; y <= 1; ++y) {
      for (std::int32_t z = -1; z <= 1; ++z) {
        if (x == 0 && y == 0 && z == 0) continue;
        const std::int32_t place[3] = {at[0] + x, at[1] + y, at[2] + z};
        look(place);
      }
    }
  }
}
}  // namespace

std::uint64_t PlaneGrowing::next_cost() const {
  switch (stage_) {
    case Stage::settle:
      return memory_.regions[growing_ - 1u].cells / 8 + 1;
    case Stage::finish:
      return region_at_ < regions_end_ ? memory_.regions[region_at_].cells / 4 + 1 : 1;
    case Stage::merge:
      return regions_end_ / 32 + 1;
    default:
      return 1;
  }
}

bool PlaneGrowing::run(std::uint64_t& units) {
  while (stage_ != Stage::done) {
    if (!credit_.pay(next_cost(), units)) return false;
    switch (stage_) {
      case Stage::seed:
        seed();
        break;
      case Stage::grow:
        grow();
        break;
      case Stage::settle:
        settle(growing_);
        stage_ = Stage::seed;
        break;
      case Stage::finish:
        finish();
        break;
      default:
        merge();
    }
  }
  return true;
}

bool PlaneGrowing::fits(const PlaneRegion& region, const PlaneCellSlot& cell, double& off_m) const {
  const double along = dot(region.normal, normal_of(cell));
  if ((config_.signed_normals ? along : std::fabs(along)) < least_cosine_) return false;
  const Vector3 mean{cell.mean_m[0], cell.mean_m[1], cell.mean_m[2]};
  off_m = std::fabs(dot(region.normal, mean) - region.offset_m);
  if (off_m > config_.most_offset_m) return false;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(cell.at[i] - region.anchor[i]) > kPlaneReach) return false;
  }
  return true;
}

/// The plane of a region's sums, as seen from the side that it was seen from before.
void PlaneGrowing::fit(PlaneRegion& region) {
  const PlaneMoments m = moments_of(region.sums, config_.cell_m);
  const Vector3 centre{(region.anchor[0] + 0.5) * config_.cell_m, (region.anchor[1] + 0.5) * config_.cell_m,
                       (region.anchor[2] + 0.5) * config_.cell_m};
  region.normal = (dot(m.normal, region.normal) < 0.0 ? -1.0 : 1.0) * m.normal;
  region.offset_m = dot(region.normal, centre + m.mean_m);
  region.fitted = region.cells;
}

std::uint16_t PlaneGrowing::new_region(std::uint32_t slot) {
  std::uint32_t i = 0;
  while (i < memory_.regions.size() && memory_.regions[i].cells > 0) ++i;
  if (i == memory_.regions.size()) {
    ++counts_.regions_full;
    return 0;
  }
  regions_end_ = std::max(regions_end_, i + 1);
  const PlaneCellSlot& cell = memory_.cells[slot - 1];
  PlaneRegion& region = memory_.regions[i];
  region = {};
  for (int k = 0; k < 3; ++k) region.anchor[k] = cell.at[k];
  region.normal = normal_of(cell);
  region.offset_m = dot(region.normal, {cell.mean_m[0], cell.mean_m[1], cell.mean_m[2]});
  region.fitted = 1;
  region.id = ++ids_;
  ++counts_.seeds;
  return static_cast<std::uint16_t>(i + 1);
}

std::uint16_t PlaneGrowing::best_neighbour(const PlaneCellSlot& cell) const {
  std::uint16_t best = 0;
  double least = 0.0;
  around(cell.at, [&](const std::int32_t(&place)[3]) {
    const std::uint32_t slot = find(place);
    const std::uint16_t number = slot == 0 ? std::uint16_t{0} : memory_.cells[slot - 1].region;
    double off = 0.0;
    if (number == 0 || number == best || !fits(memory_.regions[number - 1u], cell, off)) return;
    const bool older =
        best != 0 && off == least && memory_.regions[number - 1u].id < memory_.regions[best - 1u].id;
    if (best == 0 || off < least || older) best = number, least = off;
  });
  return best;
}

void PlaneGrowing::seed() {
  if (heap_size_ == 0) {
    stage_ = Stage::finish;
    region_at_ = 0;
    return;
  }
  const std::uint32_t slot = pop();
  if (slot == 0) return;
  const PlaneCellSlot& cell = memory_.cells[slot - 1];
  if (cell.region != 0 || cell.flat == 0) return;
  growing_ = best_neighbour(cell);
  if (growing_ == 0) growing_ = new_region(slot);
  if (growing_ == 0) return;
  put_in(slot, growing_);
  queue_begin_ = 0;
  queue_end_ = 1;
  memory_.queue[0] = slot;
  stage_ = Stage::grow;
}

void PlaneGrowing::grow() {
  PlaneRegion& region = memory_.regions[growing_ - 1u];
  if (queue_begin_ == queue_end_ || region.cells == 0) {
    // A new region is judged at once, so that what it lets go can be a seed; others once at the end.
    stage_ = region.cells > 0 && region.shape.id != region.id ? Stage::settle : Stage::seed;
    return;
  }
  const std::uint32_t slot = memory_.queue[queue_begin_++];
  if (memory_.cells[slot - 1].region != growing_) return;  // it has changed meanwhile
  if (2 * region.cells > 3 * region.fitted) fit(region);
  around(memory_.cells[slot - 1].at, [&](const std::int32_t(&place)[3]) {
    const std::uint32_t other = find(place);
    if (other == 0) return;
    const PlaneCellSlot& cell = memory_.cells[other - 1];
    double off = 0.0;
    if (cell.region != 0 || cell.flat == 0 || !fits(region, cell, off)) return;
    if (queue_end_ == memory_.queue.size()) return;
    put_in(other, growing_);
    memory_.queue[queue_end_++] = other;
  });
}

void PlaneGrowing::dissolve(std::uint16_t number) {
  while (memory_.regions[number - 1u].cells > 0) take_out(memory_.regions[number - 1u].first);
}

/// Fits a region to all of its cells, lets go those that it does not fit (they may be seeds once), and
/// dissolves it where too few are left.
void PlaneGrowing::settle(std::uint16_t number) {
  PlaneRegion& region = memory_.regions[number - 1u];
  if (region.cells == 0) return;
  fit(region);
  std::uint32_t next = 0;
  for (std::uint32_t slot = region.first; slot != 0; slot = next) {
    PlaneCellSlot& cell = memory_.cells[slot - 1];
    next = cell.next;
    double off = 0.0;
    if (fits(region, cell, off)) continue;
    const bool last = region.cells == 1;
    take_out(slot);
    ++counts_.released;
    if (cell.released == 0) push(slot);
    cell.released = 1;
    if (last) return;
  }
  fit(region);
  if (region.cells < config_.min_cells)
    dissolve(number);
  else
    shape(region);
}

/// Regions that changed are settled; then, where that let cells go, these are seeds.
void PlaneGrowing::finish() {
  if (region_at_ < regions_end_) {
    PlaneRegion& region = memory_.regions[region_at_];
    ++region_at_;
    if (region.cells > 0 && (region.changed || region.cells < config_.min_cells))
      settle(static_cast<std::uint16_t>(region_at_));
    return;
  }
  while (regions_end_ > 0 && memory_.regions[regions_end_ - 1].cells == 0) --regions_end_;
  region_at_ = 0;
  stage_ = heap_size_ > 0 ? Stage::seed : Stage::merge;
}

}  // namespace sortie::mapping
