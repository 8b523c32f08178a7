// SPDX-License-Identifier: BSD-3-Clause
// The shape of a grown plane, and planes that are one.
#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_growing.hpp"
#include "mapping/registration/plane_patch.hpp"

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

constexpr double kPointsCount = 4;  ///< measurements that the variance of points is worth
}  // namespace

/// All of a plane that others see. A cell's mean counts as one measurement: errors of points in a cell may be
/// of one kind. How good it is the means themselves say; where there are few of them the points' own
/// variance, which is the most that a mean's can be, counts as four more.
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
  double scatter_m2 = 0.0;
  for (std::uint32_t slot = region.first; slot != 0; slot = memory_.cells[slot - 1].next) {
    const PlaneCellSlot& cell = memory_.cells[slot - 1];
    const Vector3 d = Vector3{cell.mean_m[0], cell.mean_m[1], cell.mean_m[2]} - p.centroid_m;
    const double at[2] = {dot(d, p.axis_u), dot(d, v)};
    scatter_m2 += dot(d, p.normal) * dot(d, p.normal);
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
  const double n = region.cells;
  const double scatter =
      (scatter_m2 + kPointsCount * m.variance_m2[0]) / (std::max(n - 3.0, 0.0) + kPointsCount);
  const double noise = std::max(std::min(scatter, m.variance_m2[0]), 1e-6);
  p.sigma_offset_m = std::sqrt(noise / n);
  for (int k = 0; k < 2; ++k)  // a turn about u is held by what lies along v
    p.sigma_tilt_rad[k] = std::sqrt(noise / (n * std::max(m.variance_m2[1 + k], 1e-4)));
  p.id = region.id;
  region.changed = false;
  region.single = false;
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
  a.sums.add(relative(b.sums, b.anchor, a));
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
