// SPDX-License-Identifier: BSD-3-Clause
// What the odometry knows about itself, in one struct for telemetry, tables and logs.
#pragma once

#include "estimators/attitude.hpp"
#include "estimators/track_odometry.hpp"
#include "rt/describe.hpp"

namespace sortie::firmware {

/// Bits of OdometryState::health. 0: nothing is known to be wrong.
enum OdometryHealth : std::uint32_t {
  kOdometryNotStarted = 1u,       ///< no track sample was used yet
  kOdometryNotLevelled = 2u,      ///< roll and pitch do not come from the accelerometer yet
  kOdometryAttitudeStale = 4u,    ///< no attitude near the newest step
  kOdometryTravelUnknown = 8u,    ///< travel was lost for good
  kOdometryHeadingInvalid = 16u,  ///< a clipped, lost or dead stretch lies in the heading
  kOdometrySaturated = 32u,       ///< the newest inertial sample was clipped
  kOdometryCoasted = 64u,         ///< the newest attitude bridged a gap
  kOdometryAidRefused = 128u,     ///< tracks and accelerometer disagree about the acceleration
  kOdometrySlip = 256u,           ///< tracks and gyro disagree about the turn
  kOdometryAirborne = 512u,       ///< nothing carries the robot
  kOdometryTurnsUnknown = 1024u,  ///< the tracks claim too much more turn than the gyro to be a measure
};

/// State of the odometry. On the wire it is a fields_t on SORTIE_FIELDS_odometry_state.
struct OdometryState {
  rt::Nanoseconds stamp_ns{};   ///< of the newest used track sample
  std::uint32_t mode{};         ///< of estimators::ObstacleMode
  double confidence{};          ///< of the mode, 0..1
  double step_height_m{};       ///< of the last edge, above the plane before
  double vertical_m_s{};        ///< speed along the world's up
  double sigma_horizontal_m{};  ///< of the position since the start, the longer axis
  double sigma_vertical_m{};
  double steering_efficiency{};  ///< turn made for a turn of the tracks
  double turning_width_m{};      ///< distance of the tracks' turning centres; 0: not known
  std::uint32_t slip{};          ///< 1 while tracks and gyro disagree about the turn
  std::uint32_t health{};        ///< bits of OdometryHealth
  std::uint64_t slips{};         ///< steps with slip
  std::uint64_t imu_used{}, imu_not_finite{}, imu_out_of_range{}, imu_zero_rate{}, imu_time{};
  std::uint64_t imu_gaps{}, imu_saturated{}, imu_shortened{}, imu_aid_refused{};
  std::uint64_t track_used{}, track_not_finite{}, track_out_of_range{}, track_time{}, track_jumps{};
  std::uint64_t track_resets{}, track_no_attitude{}, track_attitude_stale{}, attitude_refused{};
  SORTIE_FIELDS(stamp_ns, mode, confidence, step_height_m, vertical_m_s, sigma_horizontal_m, sigma_vertical_m,
                steering_efficiency, turning_width_m, slip, health, slips, imu_used, imu_not_finite,
                imu_out_of_range, imu_zero_rate, imu_time, imu_gaps, imu_saturated, imu_shortened,
                imu_aid_refused, track_used, track_not_finite, track_out_of_range, track_time, track_jumps,
                track_resets, track_no_attitude, track_attitude_stale, attitude_refused)
};

/// What both estimators say about themselves. `imu_time` and `track_time` are the samples whose stamps stood
/// still, ran back or jumped. Cost: some forty copies.
OdometryState odometry_state(const estimators::TrackOdometry& odometry, const rt::AttitudeEstimate& attitude,
                             const estimators::AttitudeCounters& imu);

}  // namespace sortie::firmware
