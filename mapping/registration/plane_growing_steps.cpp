// SPDX-License-Identifier: BSD-3-Clause
// The steps of the growing: seed, grow, settle, finish, merge.
#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_growing.hpp"
#include "mapping/registration/plane_patch.hpp"

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
    const std::uint64_t cost = next_cost();
    if (units + credit_ < cost) {
      credit_ += units;
      units = 0;
      return false;
    }
    const std::uint64_t from_credit = std::min(credit_, cost);
    credit_ -= from_credit;
    units -= cost - from_credit;
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

/// All of a plane that others see. A cell's mean counts as one measurement: errors of points in a cell are of
/// one kind.
void PlaneGrowing::shape(PlaneRegion& region) {
  const PlaneMoments m = moments_of(region.sums, config_.cell_m);
  const double edge = config_.cell_m;
  Plane& p = region.shape;
  p.normal = config_.signed_normals ? region.normal : m.normal;
  p.axis_u = m.axis_u;
  p.centroid_m = Vector3{(region.anchor[0] + 0.5) * edge, (region.anchor[1] + 0.5) * edge,
                         (region.anchor[2] + 0.5) * edge} +
                 m.mean_m;
  p.offset_m = dot(p.normal, p.centroid_m);
  const Vector3 v = p.axis_v();
  const double beyond[2] = {
      0.5 * edge / std::max({std::fabs(p.axis_u.x), std::fabs(p.axis_u.y), std::fabs(p.axis_u.z)}),
      0.5 * edge / std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)})};
  for (int k = 0; k < 2; ++k) p.least_m[k] = p.most_m[k] = 0.0;
  for (std::uint32_t slot = region.first; slot != 0; slot = memory_.cells[slot - 1].next) {
    const PlaneCellSlot& cell = memory_.cells[slot - 1];
    const Vector3 d = Vector3{cell.mean_m[0], cell.mean_m[1], cell.mean_m[2]} - p.centroid_m;
    const double at[2] = {dot(d, p.axis_u), dot(d, v)};
    for (int k = 0; k < 2; ++k) {
      p.least_m[k] = std::min(p.least_m[k], at[k]);
      p.most_m[k] = std::max(p.most_m[k], at[k]);
    }
  }
  double box = 1.0;
  for (int k = 0; k < 2; ++k) {
    p.least_m[k] -= beyond[k];
    p.most_m[k] += beyond[k];
    box *= p.most_m[k] - p.least_m[k];
  }
  const double slant = std::max({std::fabs(p.normal.x), std::fabs(p.normal.y), std::fabs(p.normal.z)});
  p.area_m2 = std::min(box, region.cells * edge * edge / slant);
  const double noise = std::max(m.variance_m2[0], 1e-6);
  const double n = region.cells;
  p.sigma_offset_m = std::sqrt(noise / n);
  for (int k = 0; k < 2; ++k)  // a turn about u is held by what lies along v
    p.sigma_tilt_rad[k] = std::sqrt(noise / (n * std::max(m.variance_m2[1 + k], 1e-4)));
  p.id = region.id;
  region.changed = false;
  region.single = false;
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

bool PlaneGrowing::coplanar(const PlaneRegion& a, const PlaneRegion& b) const {
  const double along = dot(a.shape.normal, b.shape.normal);
  if ((config_.signed_normals ? along : std::fabs(along)) < merge_cosine_) return false;
  const Vector3 d = b.shape.centroid_m - a.shape.centroid_m;
  if (std::fabs(dot(d, a.shape.normal)) > config_.most_offset_m) return false;
  if (std::fabs(dot(d, b.shape.normal)) > config_.most_offset_m) return false;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(a.anchor[i] - b.anchor[i]) > kPlaneReach / 2) return false;
  }
  const PlanePatch own = own_patch(b.shape);
  const Vector3 v = b.shape.axis_v();
  const Vector3 middle = b.shape.centroid_m + own.centre[0] * b.shape.axis_u + own.centre[1] * v;
  return overlap(own_patch(a.shape), projected(a.shape, middle, own.a[0] * b.shape.axis_u, own.b[1] * v),
                 config_.merge_gap_m);
}

/// The older of two regions takes the other's cells over.
void PlaneGrowing::unite(std::uint16_t into, std::uint16_t from) {
  PlaneRegion& a = memory_.regions[into - 1u];
  PlaneRegion& b = memory_.regions[from - 1u];
  PlaneSums sums = b.sums;
  std::int64_t d[3];
  for (int i = 0; i < 3; ++i) d[i] = std::int64_t{b.anchor[i] - a.anchor[i]} * kPlaneSteps;
  sums.shift(d);
  a.sums.add(sums);
  a.cells += b.cells;
  std::uint32_t last = 0;
  for (std::uint32_t slot = b.first; slot != 0; slot = memory_.cells[slot - 1].next) {
    memory_.cells[slot - 1].region = into;
    last = slot;
  }
  memory_.cells[last - 1].next = a.first;
  if (a.first != 0) memory_.cells[a.first - 1].before = last;
  a.first = b.first;
  b = {};
  ++counts_.merged;
  fit(a);
  shape(a);
}

/// One region against all others; one that took another over is looked at again.
void PlaneGrowing::merge() {
  if (region_at_ >= regions_end_) {
    stage_ = Stage::done;
    return;
  }
  const std::uint32_t i = region_at_++;
  PlaneRegion& region = memory_.regions[i];
  if (region.cells == 0 || region.single) return;
  std::uint32_t best = regions_end_;
  for (std::uint32_t k = 0; k < regions_end_; ++k) {
    const PlaneRegion& other = memory_.regions[k];
    if (k == i || other.cells == 0 || !coplanar(region, other)) continue;
    if (best == regions_end_ || other.id < memory_.regions[best].id) best = k;
  }
  if (best == regions_end_) {
    region.single = true;
    return;
  }
  const bool into_best = memory_.regions[best].id < region.id;
  const auto number = [](std::uint32_t at) { return static_cast<std::uint16_t>(at + 1); };
  if (into_best)
    unite(number(best), number(i));
  else
    unite(number(i), number(best));
  region_at_ = into_best ? std::min(best, i) : i;
}

}  // namespace sortie::mapping
