// SPDX-License-Identifier: BSD-3-Clause
// Error measures as the evo package defines them, and the split of an orientation error into tilt and
// heading.
#include "toolchain/judge/errors.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace sortie::toolchain {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = 3.14159265358979323846;

using Vector = Eigen::Vector3d;

Vector position_of(const firmware::TimedPose& pose) { return Vector(pose.p[0], pose.p[1], pose.p[2]); }
Eigen::Isometry3d matrix(const firmware::TimedPose& pose) {
  Eigen::Isometry3d m = Eigen::Isometry3d::Identity();
  m.linear() = Eigen::Quaterniond(pose.q[0], pose.q[1], pose.q[2], pose.q[3]).normalized().toRotationMatrix();
  m.translation() = position_of(pose);
  return m;
}

bool all_have(const firmware::Trajectory& truth, std::uint32_t flag) {
  return std::all_of(truth.begin(), truth.end(),
                     [flag](const firmware::TimedPose& p) { return (p.flags & flag) != 0; });
}

double distance(const firmware::TimedPose& a, const firmware::TimedPose& b, bool in_space) {
  const double dx = a.p[0] - b.p[0];
  const double dy = a.p[1] - b.p[1];
  const double dz = in_space ? a.p[2] - b.p[2] : 0.0;
  return std::sqrt(dx * dx + dy * dy + dz * dz);
}

double path_length(const firmware::Trajectory& trajectory, bool in_space) {
  double length = 0.0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += distance(trajectory[i], trajectory[i - 1], in_space);
  return length;
}

double wrap(double angle) {
  while (angle > kPi) angle -= 2.0 * kPi;
  while (angle <= -kPi) angle += 2.0 * kPi;
  return angle;
}

/// Indices of poses that follow each other `delta_m` apart, as evo picks them.
std::vector<std::size_t> milestones(const firmware::Trajectory& estimate, double delta_m, bool in_space) {
  std::vector<std::size_t> ids;
  double path = 0.0;
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    path += distance(estimate[i], estimate[i - 1], in_space);
    if (path >= delta_m) {
      ids.push_back(i);
      path = 0.0;
    }
  }
  return ids;
}

/// Only the pairs whose truth has a position.
PairedTrajectories with_position(const PairedTrajectories& pairs) {
  PairedTrajectories kept;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    if ((pairs.truth[i].flags & rt::kTruthPosition) == 0) continue;
    kept.estimate.push_back(pairs.estimate[i]);
    kept.truth.push_back(pairs.truth[i]);
  }
  return kept;
}

}  // namespace

ErrorStats statistics(std::span<const double> errors) {
  ErrorStats stats;
  if (errors.empty()) return stats;
  const auto n = static_cast<double>(errors.size());
  stats.n = errors.size();
  double sum = 0.0;
  double squares = 0.0;
  for (const double e : errors) {
    sum += e;
    squares += e * e;
  }
  stats.mean = sum / n;
  stats.rmse = std::sqrt(squares / n);
  std::vector<double> sorted(errors.begin(), errors.end());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  stats.median = sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
  stats.max = sorted.back();
  return stats;
}

std::vector<double> absolute_errors(const PairedTrajectories& pairs) {
  std::vector<double> errors;
  errors.reserve(pairs.truth.size());
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    const std::uint32_t flags = pairs.truth[i].flags;
    const bool in_space = (flags & rt::kTruthHeight) != 0;
    errors.push_back((flags & rt::kTruthPosition) != 0 ? distance(pairs.estimate[i], pairs.truth[i], in_space)
                                                       : kNone);
  }
  return errors;
}

ErrorStats absolute_trajectory_error(const PairedTrajectories& pairs) {
  std::vector<double> errors = absolute_errors(pairs);
  std::erase_if(errors, [](double e) { return std::isnan(e); });
  return statistics(errors);
}

RelativeErrors relative_pose_error(const PairedTrajectories& all_pairs, double delta_m) {
  const PairedTrajectories pairs = with_position(all_pairs);
  const bool in_space = all_have(pairs.truth, rt::kTruthHeight);
  const bool has_orientation = all_have(pairs.truth, rt::kTruthOrientation);
  const std::vector<std::size_t> ids = milestones(pairs.estimate, delta_m, in_space);
  std::vector<double> translation;
  std::vector<double> rotation;
  for (std::size_t k = 1; k < ids.size(); ++k) {
    const std::size_t i = ids[k - 1];
    const std::size_t j = ids[k];
    if (!has_orientation) {
      translation.push_back(std::fabs(distance(pairs.truth[i], pairs.truth[j], in_space) -
                                      distance(pairs.estimate[i], pairs.estimate[j], in_space)));
      continue;
    }
    const Eigen::Isometry3d truth = matrix(pairs.truth[i]).inverse() * matrix(pairs.truth[j]);
    const Eigen::Isometry3d estimate = matrix(pairs.estimate[i]).inverse() * matrix(pairs.estimate[j]);
    const Eigen::Isometry3d error = truth.inverse() * estimate;
    const Vector t =
        in_space ? Vector(error.translation()) : Vector(error.translation().x(), error.translation().y(), 0);
    translation.push_back(t.norm());
    const Eigen::Quaterniond q(error.linear());
    rotation.push_back(2.0 * std::atan2(q.vec().norm(), std::fabs(q.w())));
  }
  return {statistics(translation), statistics(rotation)};
}

OrientationError orientation_error(const double (&e)[4], const double (&t)[4]) {
  // d = q_estimate * conj(q_truth), in the world: a turn about the vertical after a tilt about a horizontal
  // axis.
  const double w = e[0] * t[0] + e[1] * t[1] + e[2] * t[2] + e[3] * t[3];
  const double x = -e[0] * t[1] + e[1] * t[0] - e[2] * t[3] + e[3] * t[2];
  const double y = -e[0] * t[2] + e[2] * t[0] - e[3] * t[1] + e[1] * t[3];
  const double z = -e[0] * t[3] + e[3] * t[0] - e[1] * t[2] + e[2] * t[1];
  OrientationError error;
  // atan2 keeps small tilts exact where acos(sqrt(w^2 + z^2)) would lose half the digits.
  error.inclination_rad = 2.0 * std::atan2(std::sqrt(x * x + y * y), std::sqrt(w * w + z * z));
  error.heading_rad = wrap(2.0 * std::atan2(z, w));
  return error;
}

OrientationErrors orientation_errors(const PairedTrajectories& pairs) {
  const bool gated = std::any_of(pairs.truth.begin(), pairs.truth.end(), [](const firmware::TimedPose& p) {
    return (p.flags & rt::kTruthMoving) != 0;
  });
  std::vector<double> inclination;
  std::vector<double> heading;
  bool first = true;
  double offset = 0.0;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    const std::uint32_t flags = pairs.truth[i].flags;
    if ((flags & rt::kTruthOrientation) == 0) continue;
    const OrientationError error = orientation_error(pairs.estimate[i].q, pairs.truth[i].q);
    if (first) offset = error.heading_rad;
    first = false;
    if (gated && (flags & rt::kTruthMoving) == 0) continue;
    inclination.push_back(error.inclination_rad);
    heading.push_back(std::fabs(wrap(error.heading_rad - offset)));
  }
  return {statistics(inclination), statistics(heading)};
}

Drift end_drift(const PairedTrajectories& all_pairs) {
  const PairedTrajectories pairs = with_position(all_pairs);
  Drift drift;
  if (pairs.truth.size() < 2) return drift;
  const bool in_space = all_have(pairs.truth, rt::kTruthHeight);
  drift.distance_m = path_length(pairs.truth, in_space);
  if (!all_have(pairs.truth, rt::kTruthOrientation)) {
    const double way = path_length(pairs.estimate, in_space);
    if (way < drift.distance_m && way > 0.5 * drift.distance_m) drift.distance_m = way;
  }
  const Vector truth = position_of(pairs.truth.back()) - position_of(pairs.truth.front());
  const Vector estimate = position_of(pairs.estimate.back()) - position_of(pairs.estimate.front());
  const Vector error = estimate - truth;
  drift.horizontal_m = std::sqrt(error.x() * error.x() + error.y() * error.y());
  drift.vertical_m = in_space ? std::fabs(error.z()) : 0.0;
  if (drift.distance_m > 0.0) {
    drift.horizontal_percent = 100.0 * drift.horizontal_m / drift.distance_m;
    drift.vertical_percent = 100.0 * drift.vertical_m / drift.distance_m;
  }
  return drift;
}

}  // namespace sortie::toolchain
