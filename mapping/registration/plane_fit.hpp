// SPDX-License-Identifier: BSD-3-Clause
// The pose that fits given pairs of planes best, weighted by their errors, and which of its directions the
// pairs say nothing about.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane.hpp"
#include "mapping/registration/plane_pose.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// A plane of the source and the plane of the target that it is taken for.
struct PlanePair {
  std::uint16_t source{};
  std::uint16_t target{};
  bool opposite{};  ///< their normals point to opposite sides
  SORTIE_FIELDS(source, target, opposite)
};

/// What counts as observed, and errors that no fit of a plane knows of.
struct PlaneFitConfig {
  double observed_sigma_m{0.05};      ///< a direction of translation counts as observed below it
  double observed_sigma_rad{0.0175};  ///< an axis of rotation counts as observed below it
  double model_sigma_m{0.005};        ///< added to every offset: walls are not flat
  double model_sigma_rad{0.002};      ///< added to every normal
  double kernel_sigmas{0};  ///< residuals so large count a quarter (Geman, McClure 1985); 0: all count
};

/// Result of a fit. Changes are small turns about the target's axes, the shift of the pivot, and the
/// logarithm of the scale about the pivot, in this order: 7 numbers.
struct PlaneFit {
  PlanePose T_target_source;
  rt::Vector3 pivot_source_m;    ///< weighted middle of the source's planes; what turns and scale are about
  rt::Vector3 pivot_target_m;    ///< where it lies in the target
  double covariance[7][7]{};     ///< of (turn rad, pivot m, ln scale); 0 in what is not observed
  std::uint8_t rotation_rank{};  ///< axes of rotation that normals (and gravity) show, 0..3
  std::uint8_t translation_rank{};  ///< directions that offsets show, 0..3; with a scale 0..4
  /// Axes of rotation, least seen first: the first 3 - rotation_rank keep the estimate's turn.
  rt::Vector3 rotation_axis[3];
  /// Directions of translation, least seen first: the first (3 or 4) - translation_rank keep the estimate's
  /// place of the pivot. The fourth number is the share of the scale, in lever_m.
  double direction[4][4]{};
  double direction_sigma_m[4]{};  ///< standard deviations along them; 1e9 where nothing is known
  double lever_m{1};              ///< what a relative change of scale moves planes by
  double chi2{};                  ///< sum of squared, whitened residuals before the last step
  std::uint32_t rows{};           ///< residuals in it
  bool finite{};                  ///< false: the pairs could not be fitted; T_target_source is the start's

  SORTIE_FIELDS(T_target_source, pivot_source_m, pivot_target_m, covariance, rotation_rank, translation_rank,
                rotation_axis, direction, direction_sigma_m, lever_m, chi2, rows, finite)
};

/// Standard deviation of the distance between plane `s` at a point and plane `t`: errors of both offsets, of
/// the target's tilt with its lever (coordinates `along_u_m`, `along_v_m` of the point), and the model's.
double offset_variance(const Plane& s, const Plane& t, double scale, double along_u_m, double along_v_m,
                       const PlaneFitConfig& config);

/// Gauss-Newton over normals n_t x R n_s, offsets n_t . (s R c_s + p - c_t), and the vertical of `estimate`
/// where it has one; `steps` of it from `start`. The rotation's rank is that of normals and vertical, sigma =
/// 1 / singular value below observed_sigma_rad. The translation's (and the scale's, as a fourth column) is
/// that of what is left of the offsets' information once the rotation has been taken out: singular values
/// sigma_i of the whitened system with 1 / sigma_i < observed_sigma_m. Directions i <= r get sigma_i^-1 (u_i
/// . d) v_i, the others (t_e . v_i) v_i from `estimate` ("3D mapping for multi hybrid robot cooperation",
/// equations 5 to 8, which as printed have sigma_1 in the first sum and a sigma^-1 too many in the second).
/// Planes are indexed by `pairs`, which must be valid. Deterministic; the order of pairs matters in the last
/// bits. About 0.15 us a pair and step + 2 us a step.
PlaneFit fit_planes(std::span<const Plane> source, std::span<const Plane> target,
                    std::span<const PlanePair> pairs, const PlanePose& start, const PlaneEstimate& estimate,
                    const PlaneFitConfig& config, int steps);

}  // namespace sortie::mapping
