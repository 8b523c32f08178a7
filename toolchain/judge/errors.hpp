// SPDX-License-Identifier: BSD-3-Clause
// Errors of paired trajectories: absolute (ATE), relative (RPE), of orientation, and drift over distance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "toolchain/judge/trajectory.hpp"

namespace sortie::toolchain {

/// Statistics of a list of error magnitudes, as evo names them. All zero for an empty list.
struct ErrorStats {
  std::size_t n{};
  double rmse{};
  double mean{};
  double median{};
  double max{};
};

/// Statistics of `errors`.
ErrorStats statistics(std::span<const double> errors);

/// Distance of each pair in m, NaN where the truth has no position. In the horizontal plane where the truth
/// has no height. Align first.
std::vector<double> absolute_errors(const PairedTrajectories& pairs);

/// Statistics of absolute_errors over the pairs that have one: the ATE of evo (`evo_ape`, translation part).
ErrorStats absolute_trajectory_error(const PairedTrajectories& pairs);

/// Relative error: statistics over the motions from i to j.
struct RelativeErrors {
  ErrorStats translation_m;
  ErrorStats rotation_rad;  ///< empty where the truth has no orientation
};

/// RPE of evo (`evo_rpe`): E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j) over consecutive, not overlapping pairs `delta_m`
/// apart, measured on the estimate. Where the truth has no orientation, the difference of the distances |ij|
/// is taken (evo: point_distance). Independent of any alignment.
RelativeErrors relative_pose_error(const PairedTrajectories& pairs, double delta_m);

/// One orientation error. Inclination is the tilt between the two vertical axes; heading is the rest, about
/// the world's vertical (D. Laidig et al., BROAD, 2021).
struct OrientationError {
  double inclination_rad{};
  double heading_rad{};  ///< signed, in (-pi, pi]
};

/// The error of q_estimate against q_truth, both w x y z.
OrientationError orientation_error(const double (&q_estimate)[4], const double (&q_truth)[4]);

/// Statistics of orientation over the pairs that count.
struct OrientationErrors {
  ErrorStats inclination_rad;
  ErrorStats heading_rad;  ///< of magnitudes, after the offset at the first truth was taken off
};

/// Errors of orientation over pairs whose truth has one; only those with kTruthMoving if any pair has that
/// flag. The heading error of the first pair with an orientation is subtracted from all.
OrientationErrors orientation_errors(const PairedTrajectories& pairs);

/// Where a run ended against where it should have: displacement from the first to the last pair with a
/// position. Align first (only the rotation matters).
struct Drift {
  /// Path length of the truth (horizontal where it has no height). Noise can only lengthen a path, so of a
  /// truth that is positions alone (GPS) and the estimate the shorter is taken, unless it is less than half.
  double distance_m{};
  double horizontal_m{};        ///< error of the displacement in the plane
  double vertical_m{};          ///< error of the displacement in height, 0 where the truth has none
  double horizontal_percent{};  ///< of distance
  double vertical_percent{};    ///< of distance
};

/// Drift of the aligned pairs.
Drift end_drift(const PairedTrajectories& pairs);

}  // namespace sortie::toolchain
