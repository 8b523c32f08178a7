// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/match_score.hpp"

#include <algorithm>
#include <cmath>

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
    const Surfel* const surfel = layer.surfel_at(place.cell);
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
  const double thin = 0.075 * cell;  // standard deviation of a surface that stops a ray
  std::uint32_t through = 0;
  SurfelPlace place;
  for (std::size_t i = 0; i < looked_at; ++i) {
    const SamplePoint& point = sample[i * sample.size() / looked_at];
    const rt::Vector3 v = point.at();
    const double range = rt::norm(v);
    const rt::Vector3 ray = rt::rotate(pose.q, (1.0 / range) * v);
    // Half a cell at a time; a surface that the return itself may lie on does not count.
    const double end = std::min(range - 1.5 * cell, 0.5 * cell * most_steps);
    for (double s = 1.5 * cell; s < end; s += 0.5 * cell) {
      const rt::Vector3 p = pose.p + s * ray;
      if (!layer.place(p.x, p.y, p.z, place)) break;
      const Surfel* const surfel = layer.surfel_at(place.cell);
      if (surfel == nullptr) continue;
      // Flat, and filled by its surface from wall to wall: no edge, no bush.
      if (surfel->variance(0) > thin * thin || surfel->variance(1) < cell * cell / 16.0) continue;
      const rt::Vector3 n = surfel->normal();
      const double slope = rt::dot(n, ray);
      if (std::fabs(slope) < 0.25) continue;  // grazing
      const rt::Vector3 mean = layer.centre_m(place.cell) + surfel->mean();
      const double hit =
          rt::dot(n, mean - pose.p) / slope;  // range at which the ray meets the surface's plane
      const rt::Vector3 at = pose.p + hit * ray - mean;
      // Through the middle of it, and well before the return.
      if (rt::dot(at, at) < 0.16 * cell * cell && hit < range - 1.0 * cell) {
        ++through;
        break;
      }
    }
  }
  return through;
}

}  // namespace sortie::mapping
