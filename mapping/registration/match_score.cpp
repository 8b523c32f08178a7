// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/match_score.hpp"

#include <algorithm>

#include "mapping/registration/ray_surfaces.hpp"

namespace sortie::mapping {
MatchScore match_score(const SurfelLayer& layer, std::span<const SamplePoint> sample, const RigidPose& pose,
                       double sigma_m) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q);
  MatchScore score;
  if (sample.empty()) return score;
  std::uint32_t known = 0;
  std::uint32_t matched = 0;
  SurfelPlace place;
  for (const SamplePoint& point : sample) {
    const rt::Vector3 p = r * point.at() + pose.p;
    if (!layer.place(p.x, p.y, p.z, place)) continue;
    const Surfel* const surfel = layer.surfel_met(place.cell, p - pose.p);
    if (surfel == nullptr) continue;
    ++known;
    const double d2 = squared_deviations(*surfel, layer.from_centre_m(place), sigma_m * sigma_m);
    if (d2 < 9.0) ++matched;
    score.value += 1.0 / (1.0 + d2 * d2 / 9.0);
  }
  const auto all = static_cast<double>(sample.size());
  score.value /= all;
  score.matched = matched / all;
  score.known = known / all;
  return score;
}

std::uint32_t rays_through_surfaces(const SurfelLayer& layer, std::span<const SamplePoint> sample,
                                    const RigidPose& pose, std::uint32_t rays, std::uint32_t most_steps) {
  const double cell = layer.cell_m();
  const std::size_t looked_at = std::min<std::size_t>(rays, sample.size());
  std::uint32_t through = 0;
  for (std::size_t i = 0; i < looked_at; ++i) {
    const SamplePoint& point = sample[i * sample.size() / looked_at];
    const rt::Vector3 v = point.at();
    const double range = rt::norm(v);
    const rt::Vector3 ray = rt::rotate(pose.q, (1.0 / range) * v);
    // A surface that the return itself may lie on does not count.
    const double end = std::min(range - 1.5 * cell, 0.5 * cell * most_steps);
    // It fills its cell from wall to wall, no edge, no bush; the ray goes through the middle of it, well
    // before the return.
    through += meets_surface(layer, pose.p, ray, 1.5 * cell, end,
                             [&](const Surfel& surfel, double range_m, const rt::Vector3& off) {
                               return surfel.variance(1) >= cell * cell / 16.0 &&
                                      rt::dot(off, off) < 0.16 * cell * cell && range_m < range - 1.0 * cell;
                             });
  }
  return through;
}

}  // namespace sortie::mapping
