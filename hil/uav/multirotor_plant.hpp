// SPDX-License-Identifier: BSD-3-Clause
// A simulated multirotor in flight: commands in, exact motion out, with weather, battery, faults and ground.
#pragma once

#include <cstdint>

#include "hil/imu_truth.hpp"
#include "hil/uav/multirotor_dynamics.hpp"
#include "rt/status.hpp"
#include "rt/time.hpp"

namespace sortie::hil {

/// How the plant integrates.
enum class MultirotorMode : std::uint32_t {
  exact,   ///< Runge-Kutta of order 4 with exact rotor lags
  parity,  ///< as RotorS does
};

/// A force on the body for some time.
struct Gust {
  Vec3 force_n;  ///< world frame
  double start_s{};
  double length_s{};
};

/// How the vehicle met the ground for the first time.
struct TouchDown {
  bool happened{};
  double time_s{};
  Vec3 p_world_m;
  double speed_m_s{};  ///< of the origin, all directions
  double sink_m_s{};   ///< downward part of it
  double tilt_rad{};
};

/// The vehicle. About 1.5 kB, no heap. Deterministic: equal commands give equal motion on every compiler and
/// processor. One thread at a time.
class MultirotorPlant {
 public:
  static constexpr std::uint32_t kMaxGusts = 8;

  /// Starts at rest at `p_world_m` with `yaw_rad`, rotors at hover speed (standing when on the ground).
  /// Throws std::runtime_error naming the setting if the config is not usable.
  MultirotorPlant(const MultirotorConfig& config, const Vec3& p_world_m, double yaw_rad);

  /// Steady wind from now on.
  void set_wind(const Vec3& wind_m_s) { wind_ = wind_m_s; }
  /// `full` when there are kMaxGusts already.
  [[nodiscard]] Status add_gust(const Gust& gust);
  /// The propeller is off: no thrust, no torque, from now on.
  void fail_rotor(std::uint32_t rotor) { dynamics_.set_rotor_share(rotor, 0.0); }
  /// Share of the nominal thrust that all rotors make; lost ones stay lost.
  void set_thrust_share(double share);
  void set_mode(MultirotorMode mode) { mode_ = mode; }

  /// Commands for the rotors, rad/s, one each. A NaN counts as 0; the rest is held within 0 and the largest
  /// speed, as RotorS does. Counts what it had to change.
  void command(const double* speeds_rad_s);

  /// Moves on by `dt_s` (0.1..50 ms). not_finite or out_of_range: nothing is done. A gust acts in a step in
  /// which it begins at or before the step's start. About 2 us.
  [[nodiscard]] Status step(double dt_s);

  const MultirotorState& state() const { return state_; }
  double time_s() const { return time_s_; }
  double speed_rad_s(std::uint32_t rotor) const { return speeds_[rotor]; }
  double tilt_rad() const;
  const TouchDown& touch_down() const { return touch_down_; }
  bool on_ground() const { return on_ground_; }
  const MultirotorDynamics& dynamics() const { return dynamics_; }
  /// Battery voltage over that of a full one without load.
  double voltage_share() const { return voltage_share_; }
  std::uint64_t commands_changed() const { return commands_changed_; }

  /// Where the inertial sensor sits, from the origin, body frame; at the origin unless told.
  void set_imu_arm(const Vec3& arm_m) { imu_arm_m_ = arm_m; }
  /// Mean turn rate and mean specific force since the last call: what a perfect inertial sensor there
  /// measures, with the axes of the body.
  InertialTruth take_inertial() { return inertial_.take(); }

 private:
  MultirotorWeather weather() const;
  void drain(double dt_s);
  void meet_ground();
  void integrate_inertial(const MultirotorState& before, double dt_s);

  MultirotorDynamics dynamics_;
  MultirotorMode mode_{MultirotorMode::exact};
  MultirotorState state_;
  double speeds_[kMaxSimulatedRotors]{};
  double references_[kMaxSimulatedRotors]{};
  Gust gusts_[kMaxGusts]{};
  std::uint32_t gust_count_{};
  Vec3 wind_;
  Vec3 imu_arm_m_;
  double time_s_{};
  double charge_;
  double voltage_share_{1.0};
  bool on_ground_{};
  TouchDown touch_down_;
  InertialSum inertial_;
  std::uint64_t commands_changed_{};
};

}  // namespace sortie::hil
