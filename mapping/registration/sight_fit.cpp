// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/sight_fit.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_algebra.hpp"

namespace sortie::mapping {
namespace {
using rt::cross;
using rt::dot;
using rt::Vector3;

constexpr double kFirstGate_m = 0.25;
constexpr double kSecondGate_m = 0.12;
constexpr double kUneven_m = 0.02;     ///< standard deviation of a surface about its cell's plane
constexpr double kErrTogether = 10.0;  ///< cells that have their errors in common
constexpr double kDamping[7] = {1, 1, 1, 1, 1, 1, 400};  ///< a rad, a metre, a twentieth of the scale

struct SightSystem : LeastSquares<7> {
  std::uint32_t pairs{};
};

SightSystem sight_system(std::span<const SightCell> source, const SightLayer& target, const PlanePose& pose,
                         const Vector3& pivot, double gate_m, double least_cosine, std::uint32_t stride) {
  SightSystem system;
  const rt::RotationMatrix r = rt::to_matrix(pose.q_target_source);
  for (std::size_t i = 0; i < source.size(); i += stride) {
    const SightCell& cell = source[i];
    const Vector3 p = pose.scale * (r * cell.mean_m) + pose.p_target_source_m;
    bool known{};
    const SightCell* const surface = surface_at(target, p, r * cell.normal, gate_m, least_cosine, known);
    if (surface == nullptr) continue;
    const double residual = dot(surface->normal, p - surface->mean_m);
    const double u2 = squared(residual / gate_m);
    const double variance = squared(kUneven_m) + squared(pose.scale * cell.sigma_m);
    const double weight = squared(1.0 - u2) / (kErrTogether * variance);
    const Vector3 arm = p - pivot;
    const Vector3 turn = cross(arm, surface->normal);
    const Vector3& n = surface->normal;
    system.add({turn.x, turn.y, turn.z, n.x, n.y, n.z, dot(n, arm)}, residual, weight * stride);
    ++system.pairs;
  }
  return system;
}

/// The vertical, where the source believes it to be.
void add_vertical(const PlanePose& pose, const PlaneEstimate& estimate, SightSystem& system) {
  const rt::RotationMatrix known = rt::to_matrix(estimate.T_target_source.q_target_source);
  const Vector3 up = rt::rotate(pose.q_target_source, {known.m[6], known.m[7], known.m[8]});
  const double weight = 1.0 / squared(estimate.sigma_tilt_rad);
  system.add({0.0, up.z, -up.y, 0, 0, 0, 0}, up.x, weight);
  system.add({-up.z, 0.0, up.x, 0, 0, 0, 0}, up.y, weight);
}

/// The largest standard deviation among three of the unknowns.
double largest_sigma(const double (&l)[7][7], int n, int first) {
  double part[3][3]{};
  for (int j = 0; j < 3; ++j) {
    double x[7]{};
    x[first + j] = 1.0;
    solve(l, n, x);
    for (int i = 0; i < 3; ++i) part[i][j] = x[first + i];
  }
  return std::sqrt(std::max(0.0, eigen_pairs(part).value[2]));
}
}  // namespace

SightFit fit_sights(std::span<const SightCell> source, const SightLayer& target, const PlanePose& start,
                    const PlaneEstimate& estimate, const SightGates& gates, int steps, std::uint32_t stride) {
  SightFit fit;
  fit.T_target_source = start;
  if (source.empty()) return fit;
  Vector3 middle;
  for (const SightCell& cell : source)
    middle = middle + (1.0 / static_cast<double>(source.size())) * cell.mean_m;
  const int n = estimate.wants_scale() ? 7 : 6;
  for (int step = 0; step < steps; ++step) {
    PlanePose& pose = fit.T_target_source;
    const Vector3 pivot = transform(pose, middle);
    const double gate = step < 2 ? kFirstGate_m : step < 4 ? kSecondGate_m : 1.3 * gates.distance_m;
    SightSystem system = sight_system(source, target, pose, pivot, gate, gates.least_cosine, stride);
    if (estimate.has_gravity()) add_vertical(pose, estimate, system);
    system.fill();
    fit.pairs = system.pairs;
    for (int i = 0; i < 7; ++i) system.h[i][i] += kDamping[i];
    if (!factorise(system.h, n)) return fit;
    double change[7];
    for (int i = 0; i < 7; ++i) change[i] = i < n ? system.g[i] : 0.0;
    solve(system.h, n, change);
    pose = changed(pose, pivot, change);
    if (step + 1 < steps) continue;
    fit.sigma_rad = largest_sigma(system.h, n, 0);
    fit.sigma_m = largest_sigma(system.h, n, 3);
  }
  return fit;
}

}  // namespace sortie::mapping
