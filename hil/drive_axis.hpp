// SPDX-License-Identifier: BSD-3-Clause
// What a simulated drive turns: an axis with inertia, friction, a slope, a brake and a motor that can do so
// much and no more. Without torque it coasts; nothing holds it but friction.
#pragma once

namespace sortie::hil {

/// In the axis' own unit (metres, radians, turns, increments); accelerations are of the whole inertia.
struct DriveAxisConfig {
  double motor_s2{4.0};     ///< most that the motor gives, either way
  double friction_s2{0.5};  ///< dry friction: what it takes off a moving axis, and holds of a standing one
  double damping_1_s{0.1};  ///< and of each unit of speed
  double slope_s2{0.0};     ///< what gravity pushes, in the positive direction
  double brake_s2{0.0};     ///< friction of a closed brake; 0: there is none
  double sag_s2{0.0};       ///< how far a position servo gives way to an effort of 1/s^2
};

/// What a drive does with the axis.
enum class AxisDeed : unsigned char {
  coast,     ///< no torque
  speed,     ///< to a speed, on a ramp
  position,  ///< to a position, no faster than a speed
};

/// For one step.
struct AxisWish {
  AxisDeed deed{AxisDeed::coast};
  double target{};   ///< speed or position
  double ramp_s2{};  ///< of speed; 0: as fast as the motor can
  double fastest{};  ///< of position
  bool brake_open{true};
};

/// The axis. 80 bytes, plain; exact for constant forces but for the step in which it comes to rest.
class DriveAxis {
 public:
  explicit DriveAxis(const DriveAxisConfig& config = {}, double position = 0.0)
      : config_(config), position_(position) {}

  /// `dt_s` above 0, a millisecond as a rule.
  void advance(const AxisWish& wish, double dt_s) noexcept;

  double position() const noexcept { return position_; }
  double speed() const noexcept { return speed_; }
  DriveAxisConfig& config() noexcept { return config_; }
  const DriveAxisConfig& config() const noexcept { return config_; }

 private:
  DriveAxisConfig config_;
  double position_{};
  double speed_{};
  double demand_{};     // of speed, that a servo's ramp has reached
  double effort_s2_{};  // what the motor gave in the last step; of the whole inertia
};

}  // namespace sortie::hil
