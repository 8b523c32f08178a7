// SPDX-License-Identifier: BSD-3-Clause
// Names the errors for people and scripts; only what the truth allows is named.
#include "toolchain/judge/evaluate.hpp"

#include <cmath>
#include <limits>

namespace sortie::toolchain {
namespace {

constexpr double kDegrees = 57.29577951308232;

std::vector<ErrorSample> make_series(const PairedTrajectories& pairs) {
  std::vector<ErrorSample> series;
  const std::vector<double> position = absolute_errors(pairs);
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  bool first = true;
  double offset = 0.0;
  series.reserve(position.size());
  for (std::size_t i = 0; i < position.size(); ++i) {
    ErrorSample sample{rt::to_seconds(pairs.truth[i].stamp_ns - pairs.truth.front().stamp_ns), position[i],
                       kUnknown, kUnknown};
    if ((pairs.truth[i].flags & rt::kTruthOrientation) != 0) {
      const OrientationError error = orientation_error(pairs.estimate[i].q, pairs.truth[i].q);
      if (first) offset = error.heading_rad;
      first = false;
      sample.inclination_deg = error.inclination_rad * kDegrees;
      sample.heading_deg = std::remainder((error.heading_rad - offset) * kDegrees, 360.0);
    }
    series.push_back(sample);
  }
  return series;
}

/// Along the path, where there is a position.
double vertical_rmse(const PairedTrajectories& pairs) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    if ((pairs.truth[i].flags & rt::kTruthPosition) != 0)
      errors.push_back(pairs.estimate[i].p[2] - pairs.truth[i].p[2]);
  }
  return statistics(errors).rmse;
}

using Errors = std::map<std::string, double>;

/// What the truth of the first seconds teaches; it is not judged.
void calibrate(double calibrate_s, PairedTrajectories& pairs, Errors& errors) {
  const std::int64_t until_ns = pairs.truth.front().stamp_ns + static_cast<std::int64_t>(1e9 * calibrate_s);
  const MotionCalibration calibration = fit_calibration(pairs, until_ns);
  apply(calibration, pairs.estimate);
  drop_until(pairs, until_ns);
  errors["calibrated_scale"] = calibration.scale;
  errors["calibrated_bias_deg_s"] = calibration.bias_rad_s * kDegrees;
  errors["calibrated_rmse_m"] = calibration.rms_m;
  errors["calibrated_n"] = static_cast<double>(calibration.n);
}

void judge_places(const PairedTrajectories& pairs, Errors& errors) {
  const ErrorStats ate = absolute_trajectory_error(pairs);
  errors["ate_n"] = static_cast<double>(ate.n);
  if (ate.n == 0) return;
  errors["ate_rmse_m"] = ate.rmse;
  errors["ate_mean_m"] = ate.mean;
  errors["ate_median_m"] = ate.median;
  errors["ate_max_m"] = ate.max;
  const Drift drift = end_drift(pairs);
  errors["distance_m"] = drift.distance_m;
  errors["drift_horizontal_percent"] = drift.horizontal_percent;
  bool has_height = true;
  for (const firmware::TimedPose& pose : pairs.truth)
    has_height = has_height && (pose.flags & (rt::kTruthPosition | rt::kTruthHeight)) != rt::kTruthPosition;
  if (has_height) {
    errors["drift_vertical_percent"] = drift.vertical_percent;
    errors["vertical_rmse_m"] = vertical_rmse(pairs);
  }
  const double delta_m = drift.distance_m >= 100.0 ? 10.0 : drift.distance_m >= 10.0 ? 1.0 : 0.1;
  const RelativeErrors rpe = relative_pose_error(pairs, delta_m);
  if (rpe.translation_m.n > 0) {
    errors["rpe_n"] = static_cast<double>(rpe.translation_m.n);
    errors["rpe_rmse_m"] = rpe.translation_m.rmse;
    errors["rpe_delta_m"] = delta_m;
  }
  if (rpe.rotation_rad.n > 0) errors["rpe_rmse_deg"] = rpe.rotation_rad.rmse * kDegrees;
}

}  // namespace

Evaluation evaluate(firmware::Trajectory estimate, firmware::Trajectory truth,
                    const EvaluationOptions& options) {
  Evaluation result;
  firmware::tidy(estimate);
  firmware::tidy(truth);
  result.pairs = associate(estimate, truth);
  // What an estimate does not hold is not judged: an attitude filter says nothing about places.
  for (std::size_t i = 0; i < result.pairs.truth.size(); ++i) {
    result.pairs.truth[i].flags &= result.pairs.estimate[i].flags | rt::kTruthMoving;
  }
  Errors& errors = result.errors;
  if (options.calibrate_s > 0.0 && !result.pairs.truth.empty())
    calibrate(options.calibrate_s, result.pairs, errors);
  // The heading offset of the orientation errors is taken before alignment turns the estimate.
  const OrientationErrors orientation = orientation_errors(result.pairs);
  move_by(find_alignment(result.pairs, options.align), result.pairs.estimate);
  judge_places(result.pairs, errors);
  if (orientation.inclination_rad.n > 0) {
    errors["orientation_n"] = static_cast<double>(orientation.inclination_rad.n);
    errors["inclination_rmse_deg"] = orientation.inclination_rad.rmse * kDegrees;
    errors["inclination_max_deg"] = orientation.inclination_rad.max * kDegrees;
    errors["heading_rmse_deg"] = orientation.heading_rad.rmse * kDegrees;
    errors["heading_max_deg"] = orientation.heading_rad.max * kDegrees;
  }
  result.series = make_series(result.pairs);
  return result;
}

void add_located(const firmware::Trajectory& located, const firmware::Trajectory& truth,
                 EvaluationOptions options, Evaluation& evaluation) {
  options.calibrate_s = 0.0;
  Evaluation judged = evaluate(located, truth, options);
  for (const auto& [name, value] : judged.errors) evaluation.errors["located_" + name] = value;
  evaluation.located = std::move(judged.pairs);
  if (evaluation.pairs.estimate.empty()) evaluation.series = std::move(judged.series);
}

}  // namespace sortie::toolchain
