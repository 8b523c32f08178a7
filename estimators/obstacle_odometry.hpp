// SPDX-License-Identifier: BSD-3-Clause
// What the track odometry adds on scenes with obstacles: modes of contact, and a height that feels falls.
#pragma once

#include "estimators/obstacle_modes.hpp"
#include "estimators/vertical_channel.hpp"
#include "rt/samples.hpp"

namespace sortie::estimators {

/// Settings.
struct ObstacleOdometryConfig {
  ObstacleModesConfig modes;
  VerticalChannelConfig vertical;
  double falling_m_s2{3.0};     ///< specific force along up below this: nothing carries the robot
  double longest_step_s{0.25};  ///< a longer step of the odometry is taken as on a plane
  SORTIE_FIELDS(modes, vertical, falling_m_s2, longest_step_s)
};

/// One step of the odometry, as ObstacleOdometry sees it. Attitudes in the attitude's own world.
struct TrackStep {
  double dt_s{};
  double travel_m{};
  rt::Quaternion q_begin;
  rt::Quaternion q_end;
};

/// What it makes of it.
struct TrackMotion {
  rt::Vector3 travel_world_m;
  double vertical_variance_m2{};  ///< beyond that of a plane
};

/// Modes and vertical channel behind one call. About 800 bytes, no heap, below 2 us a step.
class ObstacleOdometry {
 public:
  explicit ObstacleOdometry(const ObstacleOdometryConfig& config)
      : config_(config), modes_(config.modes), vertical_(config.vertical) {}

  /// Angles of the flippers from now on.
  void set_flippers(const FlipperAngles& flippers) { flippers_ = flippers; }

  /// Takes a sample of the accelerometer at the attitude that held then. Others than valid ones are passed
  /// over; without any, the height is the kinematics' alone.
  void feel(const rt::ImuSample& sample, const rt::Quaternion& q_world_body);

  /// Takes a step.
  TrackMotion advance(const TrackStep& step);

  const ObstacleState& state() const { return state_; }
  const VerticalChannel& vertical() const { return vertical_; }

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  ObstacleOdometryConfig config_;
  ObstacleModes modes_;
  VerticalChannel vertical_;
  FlipperAngles flippers_;
  ObstacleState state_;
  rt::Nanoseconds felt_ns_{};  ///< stamp of the last sample felt
  double felt_s_{};            ///< how long since the last step was felt
  double impulse_m_s_{};       ///< of the specific force along up in that time
  bool clipped_{};             ///< and the device clipped some of it
  rt::Vector3 v_world_m_s_;
};

}  // namespace sortie::estimators
