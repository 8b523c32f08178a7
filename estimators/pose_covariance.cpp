// SPDX-License-Identifier: BSD-3-Clause
// Covariance of a dead-reckoned pose, in 3x3 blocks.
#include "estimators/pose_covariance.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::estimators {
namespace {
using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d skew(const Vector3d& v) {
  Matrix3d s;
  s << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return s;
}

Matrix3d symmetric(const Matrix3d& m) { return 0.5 * (m + m.transpose()); }
}  // namespace

PoseCovariance::PoseCovariance(const PoseCovarianceConfig& config)
    : config_(config), position_(Matrix3d::Zero()), mixed_(Matrix3d::Zero()), rotation_(Matrix3d::Zero()) {
  const double tilt = config.tilt_sigma_rad * config.tilt_sigma_rad;
  rotation_.diagonal() << tilt, tilt, 0.0;
}

/// With e_p, e_r the errors (R_true = R exp(e_r)), d the displacement and N noise:
///   e_r' = K dR^T e_r + N_r      K forgets the tilt and keeps the heading
///   e_p' = e_p - [d]x R' e_r' + N_p
void PoseCovariance::advance(const PoseStep& step) {
  const Matrix3d& r = step.r_world_body_to;
  const double way = step.travel_world_m.norm();
  const Matrix3d turn = r.transpose() * step.r_world_body_from;
  const double angle = std::sqrt(std::max(0.0, 3.0 - turn.trace()));  // 2 sin(a / 2) of a turn a
  const Vector3d up = r.transpose().col(2);

  const double keep = config_.tilt_correlation_s / (config_.tilt_correlation_s + step.dt_s);
  const Matrix3d vertical = up * up.transpose();
  const Matrix3d level = Matrix3d::Identity() - vertical;
  const Matrix3d forget = (keep * level + vertical) * turn;
  double heading = config_.heading_rad2_per_rad * angle + config_.heading_rad2_per_s * step.dt_s;
  if (!step.attitude_known) heading += config_.unknown_heading_rad2_per_s * step.dt_s;
  const double tilt = config_.tilt_sigma_rad * config_.tilt_sigma_rad * (1.0 - keep * keep);
  rotation_ = symmetric(forget * rotation_ * forget.transpose()) + tilt * level + heading * vertical;

  const Matrix3d arm = -skew(step.travel_world_m) * r;
  const Matrix3d mixed = mixed_ * forget.transpose();
  const Matrix3d cross = arm * mixed.transpose();
  const Vector3d growth{config_.along_m2_per_m * way + step.extra_along_m2, config_.lateral_m2_per_m * way,
                        config_.vertical_m2_per_m * way + step.extra_vertical_m2};
  position_ = symmetric(position_ + cross + cross.transpose() + arm * rotation_ * arm.transpose() +
                        r * growth.asDiagonal() * r.transpose());
  mixed_ = mixed + arm * rotation_;
}

void PoseCovariance::write(double (&covariance)[36]) const {
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) {
      covariance[6 * row + col] = position_(row, col);
      covariance[6 * row + col + 3] = mixed_(row, col);
      covariance[6 * (row + 3) + col] = mixed_(col, row);
      covariance[6 * (row + 3) + col + 3] = rotation_(row, col);
    }
  }
}

void PoseCovariance::archive(rt::Archive& archive) {
  rt::Members(archive, *this, "pose covariance").fixed(config_).by_hand(position_, mixed_, rotation_);
  for (Eigen::Matrix3d* block : {&position_, &mixed_, &rotation_}) {
    for (int i = 0; i < 9; ++i) archive.value(block->data()[i]);
  }
}

}  // namespace sortie::estimators
