// SPDX-License-Identifier: BSD-3-Clause
// Umeyama, "Least-squares estimation of transformation parameters between two point patterns", 1991, eqs.
// 39-43 with c = 1; in the plane the rotation has a closed form.
#include "toolchain/judge/alignment.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

namespace sortie::toolchain {
namespace {

using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Vector = Eigen::Vector3d;

Vector position(const firmware::TimedPose& pose) { return Vector(pose.p[0], pose.p[1], pose.p[2]); }
Eigen::Quaterniond orientation(const firmware::TimedPose& pose) {
  return Eigen::Quaterniond(pose.q[0], pose.q[1], pose.q[2], pose.q[3]).normalized();
}

constexpr std::array<std::string_view, 4> kAlignmentNames{"none", "first", "se2", "se3"};  // by Alignment

RigidTransform pack(const Matrix& r, const Vector& t) {
  RigidTransform transform;
  Eigen::Map<Matrix>(transform.r) = r;
  Eigen::Map<Vector>(transform.t) = t;
  return transform;
}

RigidTransform first_pose(const firmware::TimedPose& estimate, const firmware::TimedPose& truth) {
  Matrix r = Matrix::Identity();
  if ((truth.flags & rt::kTruthOrientation) != 0) {
    r = (orientation(truth) * orientation(estimate).conjugate()).toRotationMatrix();
  }
  Vector t = position(truth) - r * position(estimate);
  if ((truth.flags & rt::kTruthHeight) == 0) t.z() = 0.0;
  return pack(r, t);
}

/// Rotation about the vertical that turns the centred estimate onto the centred truth.
Matrix planar_rotation(const Matrix& cross) {
  const double yaw = std::atan2(cross(1, 0) - cross(0, 1), cross(0, 0) + cross(1, 1));
  return Eigen::AngleAxisd(yaw, Vector::UnitZ()).toRotationMatrix();
}

Matrix spatial_rotation(const Matrix& cross) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector sign(1.0, 1.0, 1.0);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign.z() = -1.0;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

Alignment parse_alignment(std::string_view name) {
  const auto found = std::ranges::find(kAlignmentNames, name);
  if (found == kAlignmentNames.end())
    throw std::invalid_argument("unknown alignment '" + std::string(name) + "'; use none, first, se2 or se3");
  return static_cast<Alignment>(found - kAlignmentNames.begin());
}

const char* to_string(Alignment alignment) {
  return kAlignmentNames[static_cast<std::size_t>(alignment)].data();
}

RigidTransform find_alignment(const PairedTrajectories& pairs, Alignment alignment) {
  if (alignment == Alignment::none) return {};
  Vector mean_estimate = Vector::Zero();
  Vector mean_truth = Vector::Zero();
  std::size_t n = 0;
  bool has_height = true;
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    if ((pairs.truth[i].flags & rt::kTruthPosition) == 0) continue;
    if (alignment == Alignment::first) return first_pose(pairs.estimate[i], pairs.truth[i]);
    mean_estimate += position(pairs.estimate[i]);
    mean_truth += position(pairs.truth[i]);
    has_height = has_height && (pairs.truth[i].flags & rt::kTruthHeight) != 0;
    ++n;
  }
  if (n == 0) return {};
  mean_estimate /= static_cast<double>(n);
  mean_truth /= static_cast<double>(n);
  Matrix cross = Matrix::Zero();  // sum of truth * estimate^T about the means
  for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
    if ((pairs.truth[i].flags & rt::kTruthPosition) == 0) continue;
    cross +=
        (position(pairs.truth[i]) - mean_truth) * (position(pairs.estimate[i]) - mean_estimate).transpose();
  }
  // Without heights the tilt is not known: a turn in space would then lay the path on its side.
  const bool planar = alignment == Alignment::se2 || !has_height;
  Matrix r = Matrix::Identity();
  if (n >= 2) r = planar ? planar_rotation(cross) : spatial_rotation(cross);
  Vector t = mean_truth - r * mean_estimate;
  if (!has_height) t.z() = 0.0;
  return pack(r, t);
}

void move_by(const RigidTransform& transform, firmware::Trajectory& trajectory) {
  const Matrix r = Eigen::Map<const Matrix>(transform.r);
  const Vector t = Eigen::Map<const Vector>(transform.t);
  const Eigen::Quaterniond turn(Eigen::Matrix3d{r});
  for (firmware::TimedPose& pose : trajectory) {
    Eigen::Map<Vector>(pose.p) = r * position(pose) + t;
    const Eigen::Quaterniond q = (turn * orientation(pose)).normalized();
    pose.q[0] = q.w();
    pose.q[1] = q.x();
    pose.q[2] = q.y();
    pose.q[3] = q.z();
  }
}

}  // namespace sortie::toolchain
