// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/registration/plane_consensus.hpp"

#include <algorithm>
#include <cmath>

#include "mapping/registration/plane_algebra.hpp"
#include "mapping/registration/plane_patch.hpp"
#include "rt/math.hpp"

namespace sortie::mapping {
namespace {
using rt::dot;
using rt::Vector3;

/// A source plane where the pose puts it.
struct Placed {
  Vector3 normal;
  Vector3 u;
  Vector3 v;
  Vector3 centroid;
};

Placed placed(const Plane& s, const PlanePose& pose, const rt::RotationMatrix& r) {
  const Vector3 normal = r * s.normal, u = r * s.axis_u;
  return {normal, u, rt::cross(normal, u), pose.scale * (r * s.centroid_m) + pose.p_target_source_m};
}

/// Its rectangle, as plane `t` sees it.
PlanePatch patch_of(const Placed& p, const Plane& s, const Plane& t, double scale) {
  const PlanePatch own = own_patch(s);
  const Vector3 middle = p.centroid + (scale * own.centre[0]) * p.u + (scale * own.centre[1]) * p.v;
  return projected(t, middle, (scale * own.a[0]) * p.u, (scale * own.b[1]) * p.v);
}

/// ln of how much likelier a common area is for two views of one plane than for two planes that happen to
/// meet: twice its share of the smaller rectangle, [1/20, 2]. Views show mostly the same; chance does not
/// prefer any share.
double log_of_cover(const PlanePatch& here, const PlanePatch& there) {
  const double smaller = std::min(area_of(here), area_of(there));
  const double share = smaller > 0.0 ? common_area(here, there) / smaller : 0.5;
  return rt::log(std::clamp(2.0 * share, 0.05, 2.0));
}

/// What areas that differ by more than a factor of three speak against a pair: views of one plane mostly have
/// like areas, e-fold less often per factor of two beyond; a box's top is not the floor that lies under it.
double log_of_areas(double a_m2, double b_m2) {
  constexpr double kLike = 1.1;
  constexpr double kFall = 0.7;
  const double least = std::max(std::min(a_m2, b_m2), 1e-6);
  const double apart = rt::log(std::max({a_m2, b_m2, 1e-6}) / least) - kLike;
  return apart > 0.0 ? -apart / kFall : 0.0;
}

/// Squared tilt of a placed plane against another in their standard deviations: chi-square of two degrees.
double tilt_chi2(const Placed& p, const Plane& s, const Plane& t, bool opposite, double model_rad) {
  double chi2 = 0.0;
  const Vector3 axes[2] = {t.axis_u, t.axis_v()};
  const double sigma[2] = {t.sigma_tilt_rad[1], t.sigma_tilt_rad[0]};
  for (int k = 0; k < 2; ++k) {
    const double e = (opposite ? -1.0 : 1.0) * dot(axes[k], p.normal);
    const double variance = squared(sigma[k]) + squared(dot(axes[k], p.u) * s.sigma_tilt_rad[1]) +
                            squared(dot(axes[k], p.v) * s.sigma_tilt_rad[0]) + squared(model_rad);
    chi2 += e * e / variance;
  }
  return chi2;
}
}  // namespace

void pair_near(const PlaneSide& source, const PlaneSide& target, const PlaneCandidates& candidates,
               const PlanePose& pose, const PlaneRegistrationConfig& config, NearCandidates& near,
               PlanePairs& pairs) {
  const rt::RotationMatrix r = rt::to_matrix(pose.q_target_source);
  pairs.clear();
  near.clear();
  std::uint32_t k = 0;
  while (k < candidates.size()) {
    const std::uint16_t i = candidates.pair(k).source;
    const Placed p = placed(source[i], pose, r);
    double least = 0.0;
    bool some = false;
    PlanePair best;
    for (; k < candidates.size() && candidates.pair(k).source == i; ++k) {
      const PlanePair pair = candidates.pair(k);
      const Plane& t = target[pair.target];
      const double residual = dot(t.normal, p.centroid - t.centroid_m);
      if (std::fabs(residual) > 2.0 * config.search_gate_m) continue;
      (void)near.push_back(static_cast<std::uint16_t>(k));
      if (std::fabs(residual) > config.search_gate_m) continue;
      const double cosine = std::fabs(dot(t.normal, p.normal));
      const double tilt2 = 2.0 * (1.0 - cosine);
      const double parts = squared(residual / config.search_gate_m) + tilt2 / squared(config.most_angle_rad);
      if (tilt2 > squared(config.most_angle_rad) || (some && parts >= least)) continue;
      if (!overlap(own_patch(t), patch_of(p, source[i], t, pose.scale), config.overlap_margin_m)) continue;
      least = parts;
      best = pair;
      some = true;
    }
    if (some) (void)pairs.push_back(best);
  }
}

PlaneConsensus judge(const PlaneSide& source, const PlaneSide& target, const PlaneCandidates& candidates,
                     const NearCandidates& near, const PlanePose& pose, const PlaneRegistrationConfig& config,
                     PlanePairs& pairs, double* gains) {
  double best_of_target[kMostPlanes]{};
  bool has_partner[kMostPlanes]{};
  const rt::RotationMatrix r = rt::to_matrix(pose.q_target_source);
  pairs.clear();
  PlaneConsensus result;
  std::uint32_t at = 0;
  while (at < near.size()) {
    const std::uint16_t i = candidates.pair(near[at]).source;
    const Plane& s = source[i];
    const Placed p = placed(s, pose, r);
    double most = 0.0;
    PlanePair best;
    for (; at < near.size() && candidates.pair(near[at]).source == i; ++at) {
      const std::uint32_t k = near[at];
      const PlanePair pair = candidates.pair(k);
      const Plane& t = target[pair.target];
      const Vector3 d = p.centroid - t.centroid_m;
      const double residual = dot(t.normal, d);
      // More than the variance can be, before more is looked at: most candidates are far away.
      const double tilt = std::max(t.sigma_tilt_rad[0], t.sigma_tilt_rad[1]);
      const double most_variance = squared(pose.scale * s.sigma_offset_m) + squared(t.sigma_offset_m) +
                                   dot(d, d) * squared(tilt) + squared(config.fit.model_sigma_m);
      if (residual * residual > squared(config.sigmas) * most_variance) continue;
      const double variance =
          offset_variance(s, t, pose.scale, dot(d, t.axis_u), dot(d, t.axis_v()), config.fit);
      if (residual * residual > squared(config.sigmas) * variance) continue;
      if (tilt_chi2(p, s, t, pair.opposite, config.fit.model_sigma_rad) > squared(config.sigmas) + 2.0)
        continue;
      const PlanePatch there = patch_of(p, s, t, pose.scale);
      const PlanePatch here = own_patch(t);
      if (!overlap(here, there, config.overlap_margin_m)) continue;
      const double gain = candidates.worth(k) - 0.5 * (rt::log(variance) + residual * residual / variance) +
                          log_of_cover(here, there) +
                          log_of_areas(squared(pose.scale) * s.area_m2, t.area_m2);
      if (gain > most) most = gain, best = pair;
    }
    if (most == 0.0) continue;
    has_partner[i] = true;
    best_of_target[best.target] = std::max(best_of_target[best.target], most);
    gains[pairs.size()] = most;
    (void)pairs.push_back(best);
  }
  for (std::uint32_t j = 0; j < target.size(); ++j) {
    result.evidence += best_of_target[j];
    if (best_of_target[j] > 0.0) ++result.matched;
  }
  const bool source_smaller = source.size() <= target.size();
  const PlaneSide& smaller = source_smaller ? source : target;
  const PlaneSide& larger = source_smaller ? target : source;
  const PlanePose to_larger = source_smaller ? pose : inverse(pose);
  for (std::uint32_t i = 0; i < smaller.size(); ++i) {
    const bool partner = source_smaller ? has_partner[i] : best_of_target[i] > 0.0;
    if (!partner && !larger.covers(transform(to_larger, smaller[i].centroid_m), 0.0)) continue;
    ++result.expected;
    if (!partner) ++result.missed;
  }
  result.evidence += result.missed * rt::log(1.0 - config.share_matched);
  return result;
}

}  // namespace sortie::mapping
