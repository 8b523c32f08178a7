// SPDX-License-Identifier: BSD-3-Clause
// How the uncertainty of a dead-reckoned pose grows with the way.
#pragma once

#include <Eigen/Core>

#include "rt/archive.hpp"

namespace sortie::estimators {

/// Growth of the errors of a dead-reckoned pose. Random-walk parts: variances add up along the way.
struct PoseCovarianceConfig {
  double along_m2_per_m{4e-4};        ///< slip and scale: 2 cm after 1 m, 20 cm after 100 m
  double lateral_m2_per_m{1e-4};      ///< side slip
  double vertical_m2_per_m{1e-4};     ///< uneven ground
  double heading_rad2_per_rad{1e-4};  ///< gyro scale: 0.6 deg after 1 rad
  double heading_rad2_per_s{1e-8};    ///< gyro noise and bias: 0.35 deg after an hour
  double tilt_sigma_rad{0.01};        ///< roll and pitch errors stay bounded: the accelerometer sees them
  double tilt_correlation_s{5.0};     ///< and forget themselves in this time
  double unknown_heading_rad2_per_s{0.1};  ///< while the attitude is missing
};

/// What one step of the odometry tells the covariance.
struct PoseStep {
  Eigen::Vector3d travel_world_m;     ///< displacement
  Eigen::Matrix3d r_world_body_from;  ///< attitude at the step's begin
  Eigen::Matrix3d r_world_body_to;    ///< attitude at its end
  double dt_s{};                      ///< duration
  double extra_along_m2{};            ///< variance along the track beyond the model: slip, lost travel
  double extra_vertical_m2{};         ///< and along the body's normal: a mode's own
  bool attitude_known{true};          ///< false: no fresh attitude, the heading may have turned unseen
};

/// Covariance of (position in world, rotation in body): first order, exact in the lever arm of the heading
/// error. 432 bytes; about 200 multiplications a step.
class PoseCovariance {
 public:
  explicit PoseCovariance(const PoseCovarianceConfig& config);

  /// Moves the covariance along one step.
  void advance(const PoseStep& step);

  /// Writes the 6x6 matrix row-major; it is symmetric to the last bit.
  void write(double (&covariance)[36]) const;

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  PoseCovarianceConfig config_;
  Eigen::Matrix3d position_;  ///< position x position
  Eigen::Matrix3d mixed_;     ///< position x rotation
  Eigen::Matrix3d rotation_;  ///< rotation x rotation
};

}  // namespace sortie::estimators
