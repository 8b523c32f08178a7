// SPDX-License-Identifier: BSD-3-Clause
// Gains of the state controller, designed from the vehicle's time constants and a few weights.
#pragma once

#include "planner/uav_control/uav_model.hpp"

namespace sortie::planner {

/// Weights as the deviations that count the same (Bryson's rule): each state's weight is 1 / deviation^2.
/// Infinite or zero: the state has no weight of its own.
struct AxisDeviations {
  double integral_m_s{};
  double position_m{};
  double velocity_m_s{};
  double angle_rad{};
  double rate_rad_s{};
  double input{};  ///< rad/s^2 of commanded turn, m/s^2 of commanded thrust
};

/// Horizontal chain, states: integral of position, position, velocity, tilt, turn rate, angular acceleration.
struct TiltGains {
  double integral{}, position{}, velocity{}, angle{}, rate{}, acceleration{};
};
/// Vertical chain: integral of height, height, velocity, acceleration by thrust.
struct LiftGains {
  double integral{}, position{}, velocity{}, acceleration{};
};
/// Heading chain: angle, rate, angular acceleration.
struct TurnGains {
  double angle{}, rate{}, acceleration{};
};

/// Everything that the design gave.
struct StateGains {
  TiltGains tilt;
  LiftGains lift;
  TurnGains turn;
};

/// Weights of the three chains. The defaults were found with late positions, lags and thrust that are off,
/// raw steps and gusts together, not for one flight.
struct StateWeights {
  AxisDeviations tilt{0.20, 0.10, 0.40, 0.35, 2.0, 20.0};
  AxisDeviations lift{0.20, 0.10, 0.30, 0.0, 0.0, 6.0};
  AxisDeviations turn{0.0, 0.0, 0.0, 0.10, 0.8, 12.0};
  /// Angular acceleration about roll and pitch, see authority_rad_s2(), for which the tilt weights are meant.
  /// A vehicle that has less gets weights softer by as much: demands beyond what rotors can do make the chain
  /// of integrators ring.
  double full_authority_rad_s2{40.0};
};

/// Angular acceleration about the weaker of roll and pitch that rotors have both ways: half of what each
/// makes in hover, or what they have to spare above the thrust that holds a gust of half the weight, where
/// that is less.
double authority_rad_s2(const UavModel& model);

/// Designs all gains for steps of `period_s`: exact steps of the chains x' = v, v' = g theta, theta' = q,
/// q' = alpha, alpha' = (u - alpha) / tau (and their shorter sisters), then the Riccati equation, all in
/// twice the precision of a double. out_of_range when the settings cannot be met. Some ms; no heap.
[[nodiscard]] Status design_gains(const UavModel& model, double period_s, const StateWeights& weights,
                                  StateGains& gains);

}  // namespace sortie::planner
