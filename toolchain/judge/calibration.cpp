// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/judge/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

namespace sortie::toolchain {
namespace {

using Plane = std::complex<double>;  // x + i y

constexpr std::size_t kFewest = 10;
constexpr double kShortest_m = 1.0;
constexpr int kCoarse = 100;  // steps of the bias to each side
constexpr int kFine = 40;     // halvings about the best of them

double seconds(std::int64_t stamp_ns, std::int64_t since_ns) {
  return static_cast<double>(stamp_ns - since_ns) * 1e-9;
}
Plane place(const firmware::TimedPose& pose) { return {pose.p[0], pose.p[1]}; }

/// The path from its first pose, its heading freed of a bias.
std::vector<Plane> straightened(const firmware::Trajectory& path, double bias_rad_s) {
  std::vector<Plane> points(path.size());
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double middle =
        0.5 * (seconds(path[i].stamp_ns, path[0].stamp_ns) + seconds(path[i - 1].stamp_ns, path[0].stamp_ns));
    points[i] = points[i - 1] + (place(path[i]) - place(path[i - 1])) * std::polar(1.0, -bias_rad_s * middle);
  }
  return points;
}

struct Fit {
  MotionCalibration found;
  double cost{1e300};
};

/// Scale, yaw and offset for one bias, and what all that costs.
Fit fit_similarity(const std::vector<Plane>& points, const PairedTrajectories& pairs, std::size_t n,
                   double weight, double bias_rad_s, const CalibrationPrior& prior) {
  Plane mean_point, mean_truth;
  for (std::size_t i = 0; i < n; ++i) {
    mean_point += points[i] / static_cast<double>(n);
    mean_truth += place(pairs.truth[i]) / static_cast<double>(n);
  }
  Plane cross;
  double spread = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    cross += (place(pairs.truth[i]) - mean_truth) * std::conj(points[i] - mean_point);
    spread += std::norm(points[i] - mean_point);
  }
  Fit fit;
  const double sure = 1.0 / (prior.scale * prior.scale);
  if (std::abs(cross) > 0.0) fit.found.yaw_rad = std::arg(cross);
  fit.found.scale = (weight * std::abs(cross) + sure) / (weight * spread + sure);
  fit.found.bias_rad_s = bias_rad_s;
  const Plane turn = std::polar(fit.found.scale, fit.found.yaw_rad);
  const Plane offset = mean_truth - turn * mean_point;
  fit.found.offset_m[0] = offset.real();
  fit.found.offset_m[1] = offset.imag();
  double squares = 0.0;
  for (std::size_t i = 0; i < n; ++i) squares += std::norm(place(pairs.truth[i]) - turn * points[i] - offset);
  fit.found.rms_m = std::sqrt(squares / static_cast<double>(n));
  fit.found.n = n;
  const double bias = bias_rad_s / prior.bias_rad_s;
  fit.cost = weight * squares + sure * (fit.found.scale - 1.0) * (fit.found.scale - 1.0) + bias * bias;
  return fit;
}

}  // namespace

MotionCalibration fit_calibration(const PairedTrajectories& all, std::int64_t until_ns,
                                  const CalibrationPrior& prior) {
  PairedTrajectories pairs;
  for (std::size_t i = 0; i < all.truth.size() && all.truth[i].stamp_ns <= until_ns; ++i) {
    if ((all.truth[i].flags & rt::kTruthPosition) == 0) continue;
    pairs.truth.push_back(all.truth[i]);
    pairs.estimate.push_back(all.estimate[i]);
  }
  MotionCalibration none;
  const std::size_t n = pairs.truth.size();
  if (n == 0) return none;
  std::copy_n(pairs.truth[0].p, 3, none.offset_m);
  double way = 0.0;
  for (std::size_t i = 1; i < n; ++i)
    way += std::abs(place(pairs.estimate[i]) - place(pairs.estimate[i - 1]));
  const double span_s = seconds(pairs.truth[n - 1].stamp_ns, pairs.truth[0].stamp_ns);
  if (n < kFewest || way < kShortest_m || span_s <= 0.0) return none;
  // Errors of GPS come in waves: neighbours are not so many witnesses.
  const double apart_s = span_s / static_cast<double>(n - 1);
  const double share = std::min(1.0, apart_s / prior.truth_keeps_s);
  const double weight = share / (prior.truth_m * prior.truth_m);
  const auto try_bias = [&](double bias) {
    return fit_similarity(straightened(pairs.estimate, bias), pairs, n, weight, bias, prior);
  };
  const double coarse = 5.0 * prior.bias_rad_s / kCoarse;
  Fit best;
  for (int i = -kCoarse; i <= kCoarse; ++i) {
    const Fit fit = try_bias(i * coarse);
    if (fit.cost < best.cost) best = fit;
  }
  double step = coarse;
  for (int i = 0; i < kFine; ++i) {
    for (const double side : {-step, step}) {
      const Fit fit = try_bias(best.found.bias_rad_s + side);
      if (fit.cost < best.cost) best = fit;
    }
    step *= 0.7;
  }
  best.found.offset_m[2] = pairs.truth[0].p[2];
  return best.found;
}

void apply(const MotionCalibration& calibration, firmware::Trajectory& estimate) {
  if (estimate.empty()) return;
  const std::vector<Plane> points = straightened(estimate, calibration.bias_rad_s);
  const Plane turn = std::polar(calibration.scale, calibration.yaw_rad);
  const double z0 = estimate[0].p[2];
  const std::int64_t t0 = estimate[0].stamp_ns;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    firmware::TimedPose& pose = estimate[i];
    const Plane p = turn * points[i] + Plane(calibration.offset_m[0], calibration.offset_m[1]);
    pose.p[0] = p.real();
    pose.p[1] = p.imag();
    pose.p[2] = calibration.scale * (pose.p[2] - z0) + calibration.offset_m[2];
    const double half = 0.5 * (calibration.yaw_rad - calibration.bias_rad_s * seconds(pose.stamp_ns, t0));
    const double c = std::cos(half);
    const double s = std::sin(half);
    const double w = pose.q[0], x = pose.q[1], y = pose.q[2], z = pose.q[3];
    pose.q[0] = c * w - s * z;
    pose.q[1] = c * x - s * y;
    pose.q[2] = c * y + s * x;
    pose.q[3] = c * z + s * w;
  }
}

void drop_until(PairedTrajectories& pairs, std::int64_t until_ns) {
  std::size_t first = 0;
  while (first < pairs.truth.size() && pairs.truth[first].stamp_ns <= until_ns) ++first;
  const auto n = static_cast<std::ptrdiff_t>(first);
  pairs.truth.erase(pairs.truth.begin(), pairs.truth.begin() + n);
  pairs.estimate.erase(pairs.estimate.begin(), pairs.estimate.begin() + n);
}

}  // namespace sortie::toolchain
