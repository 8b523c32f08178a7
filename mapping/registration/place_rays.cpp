// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_rays.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::mapping {
namespace {
constexpr double kThin = 0.075;        ///< of a cell: standard deviation of a surface that stops a ray
constexpr double kGrazing = 0.25;      ///< least cosine between a ray and a normal
constexpr double kApart = 0.2;         ///< of a cell: the meeting may lie so far outside of what is looked at
constexpr double kLeastSpread = 1e-6;  ///< m^2
constexpr double kMostCells = 48.0;    ///< of a ray
constexpr double kBehind_m = 4.0;
constexpr double kMiddle2 = 1.0;  ///< squared standard deviations along a surface from its middle
constexpr double kAnywhere2 = 4.0;

/// Looks at each half cell of a ray between two ranges.
bool meets(const SurfelLayer& layer, const rt::Vector3& from, const rt::Vector3& ray, double near_m,
           double far_m, double most2) {
  const double cell = layer.cell_m();
  const double thin = kThin * cell;
  SurfelPlace place;
  for (double s = near_m; s < far_m; s += 0.5 * cell) {
    const rt::Vector3 p = from + s * ray;
    if (!layer.place(p.x, p.y, p.z, place)) return false;
    const Surfel* const surfel = layer.surfel_at(place.cell);
    if (surfel == nullptr || surfel->variance(0) > thin * thin) continue;
    const rt::Vector3 n = surfel->normal();
    const double slope = rt::dot(n, ray);
    if (std::fabs(slope) < kGrazing) continue;
    const rt::Vector3 mean = layer.centre_m(place.cell) + surfel->mean();
    const double hit = rt::dot(n, mean - from) / slope;
    if (hit < near_m - kApart * cell || hit > far_m + kApart * cell) continue;
    const rt::Vector3 off = from + hit * ray - mean;
    double apart2 = 0.0;
    for (int i = 1; i < 3; ++i) {
      const double along = rt::dot(surfel->along(i), off);
      apart2 += along * along / std::max(surfel->variance(i), kLeastSpread);
    }
    if (apart2 < most2) return true;
  }
  return false;
}
}  // namespace

bool goes_through(const SurfelLayer& layer, const RigidPose& pose, const rt::Vector3& at) {
  const double range = rt::norm(at);
  const double cell = layer.cell_m();
  const double far = std::min(range - cell, kMostCells * cell);
  if (!(far > cell)) return false;
  return meets(layer, pose.p, rt::rotate(pose.q, (1.0 / range) * at), cell, far, kMiddle2);
}

bool is_before_surface(const SurfelLayer& layer, const RigidPose& pose, const rt::Vector3& at) {
  const double range = rt::norm(at);
  if (!(range > 0.0)) return false;
  const double near = range + layer.cell_m();
  return meets(layer, pose.p, rt::rotate(pose.q, (1.0 / range) * at), near,
               near + std::min(kBehind_m, 8.0 * layer.cell_m()), kAnywhere2);
}

}  // namespace sortie::mapping
