// SPDX-License-Identifier: BSD-3-Clause
// The first part of a run with truth teaches heading, gyro bias and wheel scale; the rest is judged unseen.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "toolchain/judge/evaluate.hpp"

namespace {

using namespace sortie;
using namespace sortie::firmware;
using namespace sortie::toolchain;

constexpr double kCalibrationBias_rad_s = 0.0012;
constexpr double kCalibrationScale = 0.985;
constexpr std::int64_t kCalibrationMinute_ns = 60'000'000'000;

struct CalibrationPaths {
  Trajectory estimate;
  Trajectory truth;
};

/// 200 s of bends at 1 m/s; the estimate has another heading, runs 1 / scale as far and turns by the bias.
CalibrationPaths bent_paths(double noise_m) {
  std::mt19937 random(23);
  const auto noise = [&] {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() % 65536u) / 65536.0;
    return noise_m * sum;
  };
  CalibrationPaths paths;
  double tx = 3, ty = -2, ex = 0, ey = 0;
  for (int i = 0; i <= 2000; ++i) {
    const double t = 0.1 * i;
    const double heading = 0.7 + 1.1 * std::sin(0.05 * t) + 0.4 * std::sin(0.21 * t);
    const double wrong = heading - 2.0 + kCalibrationBias_rad_s * t;
    TimedPose truth;
    truth.stamp_ns = 5'000'000'000 + static_cast<std::int64_t>(100'000'000) * i;
    TimedPose estimate = truth;
    truth.p[0] = tx;
    truth.p[1] = ty;
    estimate.p[0] = ex;
    estimate.p[1] = ey;
    const double half = 0.5 * wrong;
    estimate.q[0] = std::cos(half);
    estimate.q[3] = std::sin(half);
    truth.flags = rt::kTruthPosition;
    if (i % 4 == 0) {
      truth.p[0] += noise();
      truth.p[1] += noise();
      paths.truth.push_back(truth);
    }
    paths.estimate.push_back(estimate);
    tx += 0.1 * std::cos(heading);
    ty += 0.1 * std::sin(heading);
    ex += 0.1 / kCalibrationScale * std::cos(wrong);
    ey += 0.1 / kCalibrationScale * std::sin(wrong);
  }
  return paths;
}

}  // namespace

TEST_CASE("A calibration finds heading, bias and scale") {
  const CalibrationPaths paths = bent_paths(0.0);
  PairedTrajectories pairs = associate(paths.estimate, paths.truth);
  CalibrationPrior wide;  // exact truth: the prior must not hold it back
  wide.truth_m = 0.001;
  const std::int64_t until_ns = pairs.truth.front().stamp_ns + kCalibrationMinute_ns;
  const MotionCalibration found = fit_calibration(pairs, until_ns, wide);
  CHECK(found.bias_rad_s == Approx(kCalibrationBias_rad_s).margin(2e-6));
  CHECK(found.scale == Approx(kCalibrationScale).margin(1e-4));
  CHECK(found.yaw_rad == Approx(2.0).margin(1e-3));
  CHECK(found.n == 151);
  apply(found, pairs.estimate);
  const ErrorStats all = absolute_trajectory_error(pairs);
  CHECK(all.max < 0.05);
  // Orientation is turned along.
  const double heading = 2.0 * std::atan2(pairs.estimate.back().q[3], pairs.estimate.back().q[0]);
  const double t = 200.0;
  const double true_heading = 0.7 + 1.1 * std::sin(0.05 * t) + 0.4 * std::sin(0.21 * t);
  CHECK(std::remainder(heading - true_heading, 6.283185307179586) == Approx(0.0).margin(1e-3));
}

TEST_CASE("A calibration does not look at what it is judged by") {
  const CalibrationPaths paths = bent_paths(1.0);
  PairedTrajectories pairs = associate(paths.estimate, paths.truth);
  const std::int64_t until_ns = pairs.truth.front().stamp_ns + kCalibrationMinute_ns;
  const MotionCalibration found = fit_calibration(pairs, until_ns);
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    if (pairs.truth[i].stamp_ns > until_ns) pairs.truth[i].p[0] += 1000.0;
  }
  const MotionCalibration again = fit_calibration(pairs, until_ns);
  CHECK(found.bias_rad_s == again.bias_rad_s);
  CHECK(found.scale == again.scale);
  CHECK(found.yaw_rad == again.yaw_rad);
  CHECK(found.offset_m[0] == again.offset_m[0]);

  EvaluationOptions options;
  options.calibrate_s = 60;
  const Evaluation judged = evaluate(paths.estimate, paths.truth, options);
  CHECK(judged.errors.at("calibrated_n") == 151);
  CHECK(judged.errors.at("ate_n") == static_cast<double>(paths.truth.size() - 151));
  EvaluationOptions aligned;
  aligned.align = Alignment::se2;
  // Bias and scale cost more than 10 m on this way; noise of 1 m leaves a part of that.
  CHECK(judged.errors.at("ate_rmse_m") < 10.0);
  options.align = Alignment::se2;
  CHECK(evaluate(paths.estimate, paths.truth, options).errors.at("ate_rmse_m") <
        evaluate(paths.estimate, paths.truth, aligned).errors.at("ate_rmse_m"));
}

TEST_CASE("A calibration without evidence changes nothing but the place") {
  CalibrationPaths paths = bent_paths(0.0);
  paths.truth.resize(5);
  const PairedTrajectories few = associate(paths.estimate, paths.truth);
  const MotionCalibration none = fit_calibration(few, few.truth.back().stamp_ns);
  CHECK(none.scale == 1.0);
  CHECK(none.bias_rad_s == 0.0);
  CHECK(none.n == 0);
  CHECK(fit_calibration({}, 0).n == 0);
  Trajectory nothing;
  apply(none, nothing);
  CHECK(nothing.empty());
}
