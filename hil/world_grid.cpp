// SPDX-License-Identifier: BSD-3-Clause
// Broad phase of the world: a plan-view grid of cells, and the walk of a ray through it (Amanatides and Woo).
#include <algorithm>
#include <cmath>

#include "hil/ray_clip.hpp"
#include "hil/world.hpp"

namespace sortie::hil {
namespace {

// Solids are entered into all cells within this distance. The walk may pick the wrong one of two cells when a
// ray passes their common edge within rounding (1e-13 m); with the overlap both of them know the solid.
constexpr double kOverlap_m = 1e-6;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One axis of the walk.
struct Axis {
  double next_m;  ///< range at which the ray leaves the present cell along this axis
  double step_m;  ///< range per cell
  std::int32_t step;
};

Axis make_axis(double origin, double direction, double min, double cell, std::int32_t index) {
  if (std::fabs(direction) < kParallel) return {kInfinity, kInfinity, 0};
  const double inverse = 1.0 / direction;
  const std::int32_t step = direction > 0.0 ? 1 : -1;
  const double edge = min + cell * static_cast<double>(direction > 0.0 ? index + 1 : index);
  return {(edge - origin) * inverse, cell * std::fabs(inverse), step};
}

/// Narrows [near, far] to where the ray is between min and max along one axis.
void clip(double origin, double direction, double min, double max, double& near_m, double& far_m) {
  if (std::fabs(direction) < kParallel) {
    if (origin < min || origin > max) far_m = -1.0;
    return;
  }
  const double inverse = 1.0 / direction;
  const double a = (min - origin) * inverse;
  const double b = (max - origin) * inverse;
  near_m = std::max(near_m, std::min(a, b));
  far_m = std::min(far_m, std::max(a, b));
}

std::int32_t clamped_index(double cells) {
  if (!(cells > 0.0)) return 0;
  if (cells >= static_cast<double>(World::kCells)) return World::kCells - 1;
  return static_cast<std::int32_t>(cells);
}

}  // namespace

std::int32_t World::column(double x_m) const { return clamped_index((x_m - min_x_m_) * inverse_cell_x_); }
std::int32_t World::row(double y_m) const { return clamped_index((y_m - min_y_m_) * inverse_cell_y_); }

Status World::finalize() {
  double min_x = kInfinity;
  double max_x = -kInfinity;
  double min_y = kInfinity;
  double max_y = -kInfinity;
  std::array<double, kMaxSolids> half_x{};
  std::array<double, kMaxSolids> half_y{};
  for (std::size_t i = 0; i < count_; ++i) {
    half_extents(solids_[i], half_x[i], half_y[i]);
    half_x[i] += kOverlap_m;
    half_y[i] += kOverlap_m;
    min_x = std::min(min_x, solids_[i].center_x_m - half_x[i]);
    max_x = std::max(max_x, solids_[i].center_x_m + half_x[i]);
    min_y = std::min(min_y, solids_[i].center_y_m - half_y[i]);
    max_y = std::max(max_y, solids_[i].center_y_m + half_y[i]);
  }
  cell_begin_.fill(0);
  ready_ = true;
  if (count_ == 0) return Status::ok;
  min_x_m_ = min_x;
  min_y_m_ = min_y;
  cell_x_m_ = (max_x - min_x) / static_cast<double>(kCells);
  cell_y_m_ = (max_y - min_y) / static_cast<double>(kCells);
  inverse_cell_x_ = 1.0 / cell_x_m_;
  inverse_cell_y_ = 1.0 / cell_y_m_;

  // Two passes over the same pairs: count per cell, then fill.
  const auto for_each_cell = [&](std::size_t i, auto&& visit) {
    const Solid& s = solids_[i];
    for (std::int32_t r = row(s.center_y_m - half_y[i]); r <= row(s.center_y_m + half_y[i]); ++r) {
      for (std::int32_t c = column(s.center_x_m - half_x[i]); c <= column(s.center_x_m + half_x[i]); ++c) {
        visit(static_cast<std::size_t>(r) * kCells + static_cast<std::size_t>(c));
      }
    }
  };
  std::array<std::uint32_t, kCells * kCells + 1> begin{};
  for (std::size_t i = 0; i < count_; ++i) {
    for_each_cell(i, [&](std::size_t cell) { ++begin[cell + 1]; });
  }
  for (std::size_t cell = 1; cell < begin.size(); ++cell) begin[cell] += begin[cell - 1];
  if (begin.back() > kMaxEntries) {
    ready_ = false;
    return Status::full;
  }
  for (std::size_t cell = 0; cell < begin.size(); ++cell) {
    cell_begin_[cell] = static_cast<std::uint16_t>(begin[cell]);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    for_each_cell(i, [&](std::size_t cell) {
      entries_[begin[cell]] = static_cast<std::uint16_t>(i);
      ++begin[cell];
    });
  }
  return Status::ok;
}

// The lower index wins a tie, whatever was asked first: the answer is that of the brute force.
void World::try_solid(std::size_t index, const Ray& ray, Hit& best) const {
  const Contact contact = intersect(ray, solids_[index]);
  const auto solid = static_cast<std::int32_t>(index);
  if (contact.range_m < best.range_m || (contact.range_m == best.range_m && best.solid > solid))
    best = {contact.range_m, contact.normal, solid, solids_[index].reflectivity};
}

void World::try_cell(std::int32_t cell, const Ray& ray, Tested& tested, Hit& best) const {
  const auto index = static_cast<std::size_t>(cell);
  for (std::uint16_t k = cell_begin_[index]; k < cell_begin_[index + 1]; ++k) {
    const std::uint16_t candidate = entries_[k];
    std::uint64_t& word = tested[candidate / 64u];
    const std::uint64_t bit = std::uint64_t{1} << (candidate % 64u);
    if ((word & bit) != 0) continue;
    word |= bit;
    try_solid(candidate, ray, best);
  }
}

void World::cast_cells(const Ray& ray, Hit& best) const {
  const double max_x = min_x_m_ + cell_x_m_ * static_cast<double>(kCells);
  const double max_y = min_y_m_ + cell_y_m_ * static_cast<double>(kCells);
  double near_m = 0.0;
  double far_m = best.range_m;
  clip(ray.origin_m.x, ray.direction.x, min_x_m_, max_x, near_m, far_m);
  clip(ray.origin_m.y, ray.direction.y, min_y_m_, max_y, near_m, far_m);
  if (near_m > far_m) return;
  std::int32_t c = column(ray.origin_m.x + near_m * ray.direction.x);
  std::int32_t r = row(ray.origin_m.y + near_m * ray.direction.y);
  Axis x = make_axis(ray.origin_m.x, ray.direction.x, min_x_m_, cell_x_m_, c);
  Axis y = make_axis(ray.origin_m.y, ray.direction.y, min_y_m_, cell_y_m_, r);
  Tested tested{};
  // A walk crosses each row and each column at most once: bounded by construction, and by the counter.
  for (std::int32_t steps = 0; steps < 2 * kCells; ++steps) {
    try_cell(r * kCells + c, ray, tested, best);
    const double leave = std::min(x.next_m, y.next_m);
    // One cell of slack in range: the overlap lets a solid begin slightly before its cell.
    if (leave > best.range_m + 2.0 * kOverlap_m) return;
    if (x.next_m <= y.next_m) {
      c += x.step;
      if (c < 0 || c >= kCells) return;
      x.next_m += x.step_m;
    } else {
      r += y.step;
      if (r < 0 || r >= kCells) return;
      y.next_m += y.step_m;
    }
  }
}

}  // namespace sortie::hil
