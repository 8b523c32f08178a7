// SPDX-License-Identifier: BSD-3-Clause
// Forces on a multirotor and their integration, in two ways.
#pragma once

#include "hil/uav/multirotor_config.hpp"

namespace sortie::hil {

/// State of the rigid body: place and velocity of its origin in the world (z up), attitude, body's turn rate.
struct MultirotorState {
  Vec3 p_world_m;
  Quat q_world_body;
  Vec3 v_world_m_s;
  Vec3 w_body_rad_s;
};

/// What acts from outside, in the world frame.
struct MultirotorWeather {
  Vec3 wind_m_s;    ///< velocity of the air; acts through the rotors' drag
  Vec3 force_n;     ///< on the body's origin, as RotorS' wind plugin applies its gusts
  Vec3 torque_n_m;  ///< in the body frame
};

/// Force in the world without weight, and torque in the body, on the whole vehicle.
struct MultirotorWrench {
  Vec3 force_world_n;
  Vec3 torque_body_n_m;
};

/// The rotor model of RotorS (gazebo_motor_model) on a rigid body. Rotor i at r_i with speed w_i and
/// direction s_i: thrust k_f w_i^2 along the body's z, drag -|w_i| c_d v_perp at r_i with v_perp the velocity
/// of r_i relative to the air across the axis, yaw torque -s_i k_m thrust, rolling moment -|w_i| c_r v_perp.
/// No heap.
class MultirotorDynamics {
 public:
  /// Throws std::runtime_error naming the setting if the config is not usable.
  explicit MultirotorDynamics(const MultirotorConfig& config);

  /// Rotor i makes this share of its thrust and torques from now on: 0 a lost propeller, 0.8 a worn one.
  void set_rotor_share(std::uint32_t rotor, double share) { share_[rotor] = share; }
  double rotor_share(std::uint32_t rotor) const { return share_[rotor]; }

  /// What acts on the vehicle in `state` while its rotors turn at `speeds` (rad/s, one a rotor).
  MultirotorWrench wrench(const MultirotorState& state, const double* speeds,
                          const MultirotorWeather& weather) const;

  /// One step of the classical Runge-Kutta method of order 4 for the body, with the exact rotor speeds
  /// w(t) = ref + (w0 - ref) exp(-t / tau) inside it. tau is chosen once a step: a first-order lag never
  /// crosses its reference. Stable for every step and every tau. About 1.5 us for six rotors.
  void step_exact(MultirotorState& state, double* speeds, const double* references,
                  const MultirotorWeather& weather, double dt_s) const;

  /// One step as RotorS makes it: forces from the speeds of the step before, velocities first, places with
  /// the new velocities (semi-implicit Euler, as ODE), then the exact first-order filter of each rotor.
  void step_parity(MultirotorState& state, double* speeds, const double* references,
                   const MultirotorWeather& weather, double dt_s) const;

  double mass_kg() const { return mass_kg_; }
  const Vec3& inertia_kg_m2() const { return inertia_; }
  const MultirotorConfig& config() const { return config_; }

 private:
  struct Rate;
  Rate rate(const MultirotorState& state, const double* speeds, const MultirotorWeather& weather) const;

  MultirotorConfig config_;
  double mass_kg_;
  Vec3 inertia_;
  double share_[kMaxSimulatedRotors];
};

}  // namespace sortie::hil
