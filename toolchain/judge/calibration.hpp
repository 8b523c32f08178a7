// SPDX-License-Identifier: BSD-3-Clause
// What the first part of a run with truth can teach about the rest: heading, gyro bias and wheel scale.
#pragma once

#include <cstdint>

#include "toolchain/judge/trajectory.hpp"

namespace sortie::toolchain {

/// A correction of a dead-reckoned path: every step of it is scaled, and turned by the start's heading and by
/// the bias since the start.
struct MotionCalibration {
  double scale{1.0};     ///< true metres per metre of the path
  double bias_rad_s{};   ///< what the path's heading drifts, counter-clockwise positive; is taken off
  double yaw_rad{};      ///< turn of the path's frame into the truth's, at the first pair
  double offset_m[3]{};  ///< place of the first pair in the truth's frame
  double rms_m{};        ///< of what was fitted
  std::size_t n{};       ///< pairs that were fitted
};

/// How far sensors are from what they say, one sigma, before any truth is seen: what a fit must not make up.
struct CalibrationPrior {
  double scale{0.02};                           ///< of a wheel's radius, load and tyre
  double bias_rad_s{0.1 * 0.0174532925199433};  ///< of a gyro whose bias is not known
  double truth_m{1.5};                          ///< of the truth's positions (GPS)
  double truth_keeps_s{10.0};  ///< how long an error of the truth lasts; it counts once in that time
};

/// Fits the calibration to the pairs with a position whose stamps are up to `until_ns`: the least squares of
/// distances in the plane with the priors as further observations. Scale, yaw and offset have a closed form
/// for each bias (Umeyama 1991, with scale); the bias is searched in 5 sigmas. Fewer than ten pairs, or a
/// path that stood still: nothing but the offset.
MotionCalibration fit_calibration(const PairedTrajectories& pairs, std::int64_t until_ns,
                                  const CalibrationPrior& prior = {});

/// Lays the estimate of the pairs, first to last, out again by `calibration`.
void apply(const MotionCalibration& calibration, firmware::Trajectory& estimate);

/// Removes the pairs up to `until_ns`.
void drop_until(PairedTrajectories& pairs, std::int64_t until_ns);

}  // namespace sortie::toolchain
