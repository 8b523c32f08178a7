// SPDX-License-Identifier: BSD-3-Clause
// Runs of the registration of planes on scenes, and what became of them.
#pragma once

#include "mapping/registration/plane_registration.hpp"
#include "tests/mapping/plane_scenes.hpp"

namespace sortie::tests {

/// `common` planes in three directions at least, and a third of each side seen by that side alone; the source
/// as a camera's map, the target as a laser's.
inline PlaneScene air_scene(std::uint32_t common, double scale, WorldRandom& random) {
  const std::uint32_t others = (common + 1) / 2;
  return random_scene(common, others, others, scale, {}, {0.01, 0.004, 0.6}, random);
}

/// 0: a symmetric room; 1: a mirrored hall; 2: a wrong building. 8 to 32 planes.
inline PlaneScene false_scene(int kind, WorldRandom& random) {
  const std::uint32_t planes = 8 + random.below(25);
  const std::uint32_t others = 8 + random.below(25);
  if (kind == 0) return symmetric_scene(planes, random.below(planes / 2 + 1), random);
  if (kind == 1) return mirrored_scene(planes, random);
  return wrong_building_scene(planes, others, random);
}

/// What satellites and a compass say: 3 m and 6 degrees about the truth, and a scale of 1. Nothing but
/// gravity where not `known`.
inline mapping::PlaneEstimate gps(const PlaneScene& scene, bool known, double sigma_scale,
                                  WorldRandom& random) {
  mapping::PlaneEstimate e;
  e.sigma_scale = sigma_scale;
  const double yaw = 0.1 * random.normal();
  const double x = 3 * random.normal();
  const double y = 3 * random.normal();
  const rt::Vector3 off{x, y, 3 * random.normal()};
  if (!known) return e;
  e.T_target_source.q_target_source = rt::from_yaw_pitch_roll(yaw, 0, 0) * scene.truth.q_target_source;
  const rt::Vector3 middle = middle_of(scene.source);
  e.T_target_source.p_target_source_m =
      transform(scene.truth, middle) + off - rt::rotate(e.T_target_source.q_target_source, middle);
  e.sigma_position_m = 3;
  e.sigma_yaw_rad = 0.1;
  return e;
}

/// One registration from begin to end; the verdict is `none` where begin() refused.
inline mapping::PlaneRegistrationResult registered(mapping::PlaneRegistration& registration,
                                                   const PlaneScene& scene,
                                                   const mapping::PlaneEstimate& estimate) {
  if (registration.begin(scene.source, scene.target, estimate) != Status::ok) return {};
  std::uint64_t units = std::uint64_t{1} << 60;
  (void)registration.run(units);
  return registration.result();
}

/// How far a fit is off in the directions that it calls observed, its scale among them.
inline double observed_error_m(const PlaneScene& scene, const mapping::PlaneFit& fit) {
  const rt::Vector3 d = fit.pivot_target_m - transform(scene.truth, fit.pivot_source_m);
  const double grown = fit.lever_m * std::log(fit.T_target_source.scale / scene.truth.scale);
  double squared = 0.0;
  for (int k = 0; k < 4; ++k) {
    if (!(fit.direction_sigma_m[k] > 0.0 && fit.direction_sigma_m[k] < 0.05)) continue;
    const double* const v = fit.direction[k];
    const double part = v[0] * d.x + v[1] * d.y + v[2] * d.z + v[3] * grown;
    squared += part * part;
  }
  return std::sqrt(squared);
}

/// Places within 5 cm, 0.3 degrees and 0.5 % of scale; within 10 cm and 1 degree; wrong; refused. Of a place
/// that is known in part only what it observes counts.
struct PlaneTally {
  std::uint32_t close{};
  std::uint32_t near{};
  std::uint32_t wrong{};
  std::uint32_t refused{};

  void judge(const PlaneScene& scene, const mapping::PlaneRegistrationResult& result, bool nowhere = false) {
    if (!result.placed()) {
      ++refused;
      return;
    }
    PoseError e = pose_error(scene, result.fit.T_target_source);
    if (result.verdict == mapping::PlaneVerdict::placed_partly) {
      e.position_m = observed_error_m(scene, result.fit);
      e.scale = 0.0;
    }
    count(e, nowhere);
  }

  /// `nowhere`: any place is wrong.
  void count(const PoseError& e, bool nowhere) {
    if (nowhere || e.position_m > 0.1 || e.angle_rad > 0.0175)
      ++wrong;
    else if (e.position_m > 0.05 || e.angle_rad > 0.3 / 57.29577951308232 || e.scale > 0.005)
      ++near;
    else
      ++close;
  }
};

/// What became of `trials` false scenes of a kind, seeds from `seed` on. Where a mirrored hall or a wrong
/// building is placed at all, that is wrong.
inline PlaneTally false_places(mapping::PlaneRegistration& registration, int kind, std::uint32_t seed,
                               std::uint32_t trials) {
  PlaneTally tally;
  for (std::uint32_t i = 0; i < trials; ++i) {
    WorldRandom random(seed + i);
    const PlaneScene scene = false_scene(kind, random);
    tally.judge(scene, registered(registration, scene, {}), kind > 0);
  }
  return tally;
}

}  // namespace sortie::tests
