// SPDX-License-Identifier: BSD-3-Clause
// Height from two sources that fail differently: the contacts' kinematics and the accelerometer.
#pragma once

#include "rt/archive.hpp"
#include "rt/describe.hpp"
#include "rt/rotation.hpp"

namespace sortie::estimators {

/// Settings of the vertical channel.
struct VerticalChannelConfig {
  double gravity_m_s2{9.81};
  double acc_m_s2_rt_hz{0.006};     ///< density of the accelerometer's noise, with what vibration adds
  double acc_walk_m_s2_rt_s{3e-4};  ///< growth of its bias, each axis
  double acc_bias_m_s2{0.03};       ///< of the bias at first, each axis
  double speed_m_s{0.002};          ///< of the kinematics on a plane
  double speed_share{0.01};         ///< and per speed
  double speed_keeps_s{0.2};        ///< how long such an error lasts
  double mode_keeps_m{0.05};        ///< way on which an error of a mode lasts
  double outlier{3.0};              ///< kinematics that miss by more sigmas count as that much less sure
  SORTIE_FIELDS(gravity_m_s2, acc_m_s2_rt_hz, acc_walk_m_s2_rt_s, acc_bias_m_s2, speed_m_s, speed_share,
                speed_keeps_s, mode_keeps_m, outlier)
};

/// What one step brings.
struct VerticalStep {
  double dt_s{};
  double travel_m{};    ///< of the belts
  double rise_m{};      ///< by kinematics, world's up
  double sigma_m{};     ///< of it, beyond what the config says
  double force_m_s2{};  ///< mean specific force along the world's up over the step
  rt::Vector3 up_body;  ///< the world's up in body axes at the end
};

/// A Kalman filter with five states: height, speed, bias of the accelerometer along the body's axes.
/// Kinematics measure the speed. A short event (a fall, a slide) is the accelerometer's, a long one is the
/// kinematics'; when the speed is sure again behind an obstacle, the height that the bias had cost is taken
/// back, too.
///
/// An attitude rests on the same accelerometer: a bias b_x along the body makes it lean by b_x / g, and the
/// kinematics climb by v cos(pitch) b_x / g too much. On level ground nothing shows that. On a slope the
/// force is too large by b_x sin(pitch), while the speed is steady: there the bias is seen, and with it the
/// height that its lean has made since the start. A lean that the gyro alone has made stays unseen.
/// 500 bytes, about 200 multiplications, no heap.
class VerticalChannel {
 public:
  explicit VerticalChannel(const VerticalChannelConfig& config);

  /// Takes a step; returns the rise that is to be believed. All values finite, dt above 0.
  double update(const VerticalStep& step);

  /// A step without a force: the kinematics' rise is taken, the speed is known by it alone.
  double skip(const VerticalStep& step);

  double height_m() const { return state_[0]; }
  double speed_m_s() const { return state_[1]; }
  /// Bias of the accelerometer, body axes.
  rt::Vector3 bias_m_s2() const { return {state_[2], state_[3], state_[4]}; }
  /// Variance of the height since the start, m^2.
  double height_variance_m2() const { return covariance_[0][0]; }

  /// State to bytes and back.
  void archive(rt::Archive& archive);

 private:
  static constexpr int kStates = 5;

  void predict(const VerticalStep& step);
  double speed_variance(const VerticalStep& step) const;
  /// What a bias along the body adds to the speed that kinematics tell.
  double lean(const VerticalStep& step) const;

  VerticalChannelConfig config_;
  double state_[kStates]{};
  double covariance_[kStates][kStates]{};
};

}  // namespace sortie::estimators
