// SPDX-License-Identifier: BSD-3-Clause
// The linear system of a fit of pairs of planes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mapping/registration/plane_algebra.hpp"
#include "mapping/registration/plane_fit.hpp"

namespace sortie::mapping {

/// Information and right side of the 7 unknowns, whole and of the normals' rows alone.
struct PlaneSystem {
  LeastSquares<7> whole;
  LeastSquares<3> turn;
  double chi2{};
  double kernel{};  ///< 1 / its width squared
  std::uint32_t rows{};

  double weight(double residual, double variance) const {
    const double shrunk = 1.0 + kernel * residual * residual / variance;
    return 1.0 / (variance * shrunk * shrunk);
  }

  void add(const rt::Vector3& on_turn, const rt::Vector3& on_shift, double on_scale, double residual,
           double variance) {
    const double w = weight(residual, variance);
    whole.add({on_turn.x, on_turn.y, on_turn.z, on_shift.x, on_shift.y, on_shift.z, on_scale}, residual, w);
    chi2 += w * residual * residual;
    ++rows;
  }
  /// A row that is about the rotation alone.
  void add_turn(const rt::Vector3& on_turn, double residual, double variance) {
    const double w = weight(residual, variance);
    const double j[3] = {on_turn.x, on_turn.y, on_turn.z};
    turn.add(j, residual, w);
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b <= a; ++b) whole.h[a][b] += w * j[a] * j[b];
      whole.g[a] -= w * j[a] * residual;
    }
    chi2 += w * residual * residual;
    ++rows;
  }
};

/// Variance of a normal's error along the direction `w` in its plane.
inline double tilt_variance(const Plane& p, const rt::Vector3& w) {
  return squared(rt::dot(w, p.axis_u) * p.sigma_tilt_rad[1]) +
         squared(rt::dot(w, p.axis_v()) * p.sigma_tilt_rad[0]);
}

struct PlaneFitInput {
  std::span<const Plane> source;
  std::span<const Plane> target;
  std::span<const PlanePair> pairs;
  const PlaneEstimate& estimate;
  const PlaneFitConfig& config;
};

inline PlaneSystem linearised(const PlaneFitInput& in, const PlanePose& pose, const rt::Vector3& pivot_target,
                              double& lever_m) {
  PlaneSystem system;
  if (in.config.kernel_sigmas > 0.0) system.kernel = 1.0 / squared(in.config.kernel_sigmas);
  const rt::RotationMatrix r = rt::to_matrix(pose.q_target_source);
  double levers = 0.0;
  double weights = 0.0;
  for (const PlanePair& pair : in.pairs) {
    const Plane& s = in.source[pair.source];
    const Plane& t = in.target[pair.target];
    const rt::Vector3 u = t.axis_u;
    const rt::Vector3 v = t.axis_v();
    const rt::Vector3 n = (pair.opposite ? -1.0 : 1.0) * (r * s.normal);
    const rt::Vector3 us = r * s.axis_u;
    const rt::Vector3 vs = rt::cross(r * s.normal, us);
    const double model = squared(in.config.model_sigma_rad);
    const auto source_variance = [&](const rt::Vector3& w) {
      return squared(rt::dot(w, us) * s.sigma_tilt_rad[1]) + squared(rt::dot(w, vs) * s.sigma_tilt_rad[0]);
    };
    system.add_turn(rt::cross(n, u), rt::dot(u, n), tilt_variance(t, u) + source_variance(u) + model);
    system.add_turn(rt::cross(n, v), rt::dot(v, n), tilt_variance(t, v) + source_variance(v) + model);
    const rt::Vector3 turned = pose.scale * (r * s.centroid_m);
    const rt::Vector3 at = turned + pose.p_target_source_m;
    const rt::Vector3 arm = at - pivot_target;
    const rt::Vector3 d = at - t.centroid_m;
    const double variance = offset_variance(s, t, pose.scale, rt::dot(d, u), rt::dot(d, v), in.config);
    const double along = rt::dot(t.normal, arm);
    system.add(rt::cross(arm, t.normal), t.normal, along, rt::dot(t.normal, d), variance);
    levers += along * along / variance;
    weights += 1.0 / variance;
  }
  if (in.estimate.has_gravity()) {  // the vertical, where the source believes it to be
    const rt::RotationMatrix known = rt::to_matrix(in.estimate.T_target_source.q_target_source);
    const rt::Vector3 up_source{known.m[6], known.m[7], known.m[8]};
    const rt::Vector3 up = r * up_source;
    const double variance = squared(in.estimate.sigma_tilt_rad);
    system.add_turn(rt::cross(up, {1, 0, 0}), up.x, variance);
    system.add_turn(rt::cross(up, {0, 1, 0}), up.y, variance);
  }
  lever_m = std::max(1.0, weights > 0.0 ? std::sqrt(levers / weights) : 1.0);
  system.whole.fill();
  system.turn.fill();
  return system;
}

}  // namespace sortie::mapping
