// SPDX-License-Identifier: BSD-3-Clause
// From two trajectories to the `errors` of a result: association, alignment, and every error that the truth
// allows.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "toolchain/judge/alignment.hpp"
#include "toolchain/judge/calibration.hpp"
#include "toolchain/judge/errors.hpp"
#include "toolchain/judge/trajectory.hpp"

namespace sortie::toolchain {

/// How to judge.
struct EvaluationOptions {
  Alignment align{Alignment::none};
  /// The first so many seconds calibrate heading, gyro bias and wheel scale; errors are those of the rest,
  /// without any other alignment. 0: no such thing.
  double calibrate_s{0.0};
};

/// One point of an error plot. A figure that the truth does not allow is NaN.
struct ErrorSample {
  double time_s{};  ///< since the first pair
  double position_m{};
  double inclination_deg{};
  double heading_deg{};
};

/// Errors by name, and what a plot needs.
struct Evaluation {
  /// ate_{rmse,mean,median,max}_m, ate_n; rpe_rmse_m, rpe_rmse_deg, rpe_n, rpe_delta_m (10, 1 or 0.1 m, the
  /// longest that gives ten of them);
  /// inclination_{rmse,max}_deg, heading_{rmse,max}_deg, orientation_n; drift_horizontal_percent,
  /// drift_vertical_percent, vertical_rmse_m, distance_m; with a calibration calibrated_{scale,
  /// bias_deg_s,rmse_m,n}; of a path on the robot's own map the same as located_NAME. Only what the truth
  /// allows is present.
  std::map<std::string, double> errors;
  PairedTrajectories pairs;    ///< estimate aligned
  PairedTrajectories located;  ///< the same of the path on the robot's own map; judge() alone sets it
  std::vector<ErrorSample> series;
};

/// Judges `estimate` by `truth`. Both are tidied first. Without a common stamp `errors` holds only ate_n = 0.
Evaluation evaluate(firmware::Trajectory estimate, firmware::Trajectory truth,
                    const EvaluationOptions& options = {});

/// Judges the path on the robot's own map as well: errors located_NAME. Where there is no estimate, the
/// series is that path's.
void add_located(const firmware::Trajectory& located, const firmware::Trajectory& truth,
                 EvaluationOptions options, Evaluation& evaluation);

/// Judges what a run or a replay gave (its `estimate` and its `located` by its `truth`, where they are known)
/// and puts the errors into its `results`: neither knows how it is judged. A calibration is of the estimate
/// alone.
template <class Outcome>
Evaluation judge(Outcome& outcome, const EvaluationOptions& options = {}) {
  Evaluation evaluation;
  if (outcome.truth.empty()) return evaluation;
  if (!outcome.estimate.empty()) evaluation = evaluate(outcome.estimate, outcome.truth, options);
  if (!outcome.located.empty()) add_located(outcome.located, outcome.truth, options, evaluation);
  outcome.results.errors = evaluation.errors;
  return evaluation;
}

}  // namespace sortie::toolchain
