// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/place_rays.hpp"

#include <algorithm>

#include "mapping/registration/ray_surfaces.hpp"

namespace sortie::mapping {
namespace {
constexpr double kApart = 0.2;         ///< of a cell: the meeting may lie so far outside of what is looked at
constexpr double kLeastSpread = 1e-6;  ///< m^2
constexpr double kMostCells = 48.0;    ///< of a ray
constexpr double kBehind_m = 4.0;
constexpr double kMiddle2 = 1.0;  ///< squared standard deviations along a surface from its middle
constexpr double kAnywhere2 = 4.0;

bool meets(const SurfelLayer& layer, const rt::Vector3& from, const rt::Vector3& ray, double near_m,
           double far_m, double most2) {
  const double apart_m = kApart * layer.cell_m();
  return meets_surface(layer, from, ray, near_m, far_m,
                       [&](const Surfel& surfel, double range_m, const rt::Vector3& off) {
                         if (surfel.count < kSureSurface) return false;
                         if (range_m < near_m - apart_m || range_m > far_m + apart_m) return false;
                         double apart2 = 0.0;
                         for (int i = 1; i < 3; ++i) {
                           const double along = rt::dot(surfel.along(i), off);
                           apart2 += along * along / std::max(surfel.variance(i), kLeastSpread);
                         }
                         return apart2 < most2;
                       });
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
