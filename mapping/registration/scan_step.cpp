// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/scan_step.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_algebra.hpp"

namespace sortie::mapping {
namespace {
/// Returns of one cell that count: more of them share their errors.
constexpr double kMostOfCell = 8.0;
/// Of a return's variance: what a normal may be off by where its points happen to lie well.
constexpr double kLeastNoise = 0.1;

/// What of a surface's thickness may be its bend, which more points do not make less.
constexpr double kBent = 0.03;
constexpr double kSameNormal = 0.95;  ///< cosine between two cells of one surface
constexpr double kSamePlane = 0.2;    ///< sine of the way from one to the other out of its plane

/// Sum of the squares of a cell's points along a direction, in whole steps.
double second_moment(const SurfelSums& sums, const rt::Vector3& a) {
  const auto part = [&sums](int i) { return static_cast<double>(sums.product[i]); };
  return a.x * a.x * part(0) + a.y * a.y * part(1) + a.z * a.z * part(2) +
         2.0 * (a.x * a.y * part(3) + a.x * a.z * part(4) + a.y * a.z * part(5));
}

/// The lever's share of what a cell holds, and what the noise of its normal could make of nothing: one that
/// is off by an angle about a tangent of its surface seems to hold what it does not.
void add_held(const Surfel& surfel, const rt::Vector3& x, double weight, double noise_m2,
              NormalEquations& out) {
  for (int k = 0; k < 3; ++k) {
    const rt::Vector3 t = surfel.along(k);
    const double ratio = (surfel.variance(0) + kLeastNoise * noise_m2) / surfel.variance(k);
    const double angle2 = ratio * (1.0 / static_cast<double>(surfel.count) + kBent);
    double(&sums)[6][6] = k == 0 ? out.held : out.noise;
    const double share = k == 0 ? weight : weight * angle2;
    const rt::Vector3 turn = rt::cross(x, t);
    const double j[6] = {turn.x, turn.y, turn.z, t.x, t.y, t.z};
    for (int row = 0; row < 6; ++row) {
      for (int column = 0; column < 6; ++column) sums[row][column] += share * j[row] * j[column];
    }
  }
}

/// Whether the surface of a cell goes on into a neighbour: both lie in the plane of the other. Rows and
/// columns of a lidar that cross an edge, and few returns far off, make a flat surfel where no surface is,
/// and make it again wherever the robot goes: to it, standing still fits best.
bool goes_on(const SurfelLayer& layer, const SurfelCell& cell, const Surfel& surfel) {
  for (int i = 0; i < 27; ++i) {
    if (i == 13) continue;  // the cell itself
    const std::int32_t by[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    for (SurfelIndex at = layer.find({{cell.at[0] + by[0], cell.at[1] + by[1], cell.at[2] + by[2]}});
         at != kNoSurfel; at = layer.other_side(at)) {
      const Surfel& other = layer.surfel(at);
      if (other.count == 0 || !is_surface(other, layer.cell_m()) ||
          std::abs(rt::dot(surfel.normal(), other.normal())) < kSameNormal)
        continue;
      const rt::Vector3 between =
          layer.cell_m() * rt::Vector3{1.0 * by[0], 1.0 * by[1], 1.0 * by[2]} + other.mean() - surfel.mean();
      const double off = kSamePlane * rt::norm(between);
      if (std::abs(rt::dot(surfel.normal(), between)) < off &&
          std::abs(rt::dot(other.normal(), between)) < off)
        return true;
    }
  }
  return false;
}

/// Takes out what is known of the unknowns that are held.
void keep_free_ones(NormalEquations& out) {
  for (int row = 0; row < 6; ++row) {
    if (out.holds(row)) out.g[row] = 0.0;
    for (int column = 0; column < 6; ++column) {
      if (out.holds(row) || out.holds(column))
        out.h[row][column] = out.held[row][column] = out.noise[row][column] = 0.0;
    }
  }
}
}  // namespace

std::uint32_t ScanStep::sum_up(const SurfelLayer& layer, std::span<const SamplePoint> sample,
                               const RigidPose& pose) {
  if (++stamp_ == 0) {  // after four thousand million steps: no slot may seem to be of this one
    for (StepMemory::Slot& slot : memory_.slots) slot.stamp = 0;
    stamp_ = 1;
  }
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  std::uint32_t used = 0;
  SurfelPlace place;
  for (const SamplePoint& point : sample) {
    const rt::Vector3 p = r * point.at() + pose.p;
    if (!layer.place(p.x, p.y, p.z, place)) continue;
    const SurfelIndex index = layer.find_met(place.cell, p - pose.p);
    if (index == kNoSurfel) continue;
    StepMemory::Slot& slot = memory_.slots[index];
    if (slot.stamp != stamp_) {
      slot = {stamp_, used};
      memory_.cells[used++] = {SurfelSums{}, place.cell, index};
    }
    memory_.cells[slot.at].sums.add(place.at);
  }
  return used;
}

NormalEquations ScanStep::equations(const SurfelLayer& layer, std::span<const SamplePoint> sample,
                                    const RigidPose& pose, const StepRule& rule) {
  NormalEquations out;
  out.planar = planar_;
  const std::uint32_t used = sum_up(layer, sample, pose);
  const double step = layer.cell_m() / kSurfelSteps;
  // A surface that goes on through the cell along all three axes has no normal there (extended axes of ICET,
  // McDermott and Rife 2024).
  const double extended = squared(0.25 * layer.cell_m());
  const double noise = squared(rule.sigma_m);
  for (const CellSums& cell : memory_.cells.first(used)) {
    const Surfel& surfel = layer.surfel(cell.surfel);
    const double variance = surfel.variance(0);
    if (variance > extended || !is_surface(surfel, layer.cell_m())) continue;
    const auto n = static_cast<double>(cell.sums.count);
    const rt::Vector3 mean =
        (step / n) * rt::Vector3{static_cast<double>(cell.sums.sum[0]), static_cast<double>(cell.sums.sum[1]),
                                 static_cast<double>(cell.sums.sum[2])};
    const rt::Vector3 x = layer.centre_m(cell.cell) + mean - pose.p;
    const rt::Vector3 a = surfel.normal();
    const double residual = rt::dot(a, mean - surfel.mean());
    const double own =
        std::max(0.0, step * step / n * second_moment(cell.sums, a) - squared(rt::dot(a, mean)));
    const double robust = squared(rule.scale_m) / (squared(rule.scale_m) + squared(residual));
    const double weight = std::min(n, kMostOfCell) / (variance + own + noise) * robust * robust;
    const rt::Vector3 turn = rt::cross(x, a);
    const double j[6] = {turn.x, turn.y, turn.z, a.x, a.y, a.z};
    for (int row = 0; row < 6; ++row) {
      const double wj = weight * j[row];
      for (int column = row; column < 6; ++column) out.h[row][column] += wj * j[column];
      out.g[row] += wj * residual;
    }
    if (rule.noise && (!rule.confirmed || goes_on(layer, cell.cell, surfel)))
      add_held(surfel, layer.centre_m(cell.cell) + surfel.mean() - pose.p, weight, noise, out);
    out.squares += weight * squared(residual);
    ++out.rows;
  }
  for (int row = 1; row < 6; ++row) {
    for (int column = 0; column < row; ++column) out.h[row][column] = out.h[column][row];
  }
  if (planar_) keep_free_ones(out);
  return out;
}

bool solve6(const double (&a)[6][6], const double (&b)[6], double (&x)[6]) {
  double l[6][6];
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) l[i][k] = a[i][k];
    x[i] = b[i];
  }
  // What cancels by more than 12 digits is nothing but rounding.
  if (!factorise(l, 6, 1e-12)) return false;
  solve(l, 6, x);
  return true;
}

bool ScanStep::advance(const NormalEquations& equations, const PosePrior& prior, RigidPose& pose) {
  const rt::Vector3 turned = rt::log_rotation(pose.q * rt::conjugate(prior.at.q));
  const rt::Vector3 moved = pose.p - prior.at.p;
  const double from_prior[6] = {turned.x, turned.y, turned.z, moved.x, moved.y, moved.z};
  double a[6][6];
  double b[6];
  for (int row = 0; row < 6; ++row) {
    b[row] = -equations.g[row];
    for (int column = 0; column < 6; ++column) {
      a[row][column] = equations.h[row][column] + prior.information[row][column];
      b[row] -= prior.information[row][column] * from_prior[column];
    }
  }
  for (int held = 0; held < 6; ++held) {
    if (!equations.holds(held)) continue;
    for (int i = 0; i < 6; ++i) a[held][i] = a[i][held] = 0.0;
    a[held][held] = 1.0;
    b[held] = 0.0;
  }
  double x[6];
  if (!solve6(a, b, x)) return false;
  pose.q = rt::normalised(rt::exp_rotation({x[0], x[1], x[2]}) * pose.q);
  pose.p = pose.p + rt::Vector3{x[3], x[4], x[5]};
  return true;
}

}  // namespace sortie::mapping
