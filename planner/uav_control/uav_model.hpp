// SPDX-License-Identifier: BSD-3-Clause
// What a flight controller believes about its vehicle.
#pragma once

#include <cstdint>

#include "rt/rotation.hpp"
#include "rt/status.hpp"
#include "rt/uav_samples.hpp"

namespace sortie::planner {

/// One rotor: place from the centre of mass (x forward, y left, z up), turning direction seen from above (+1
/// counter-clockwise).
struct UavRotor {
  rt::Vector3 place_m;
  double direction{1.0};
};

/// A multirotor with parallel rotors, thrust k_f w^2, yaw torque -direction k_m thrust.
struct UavModel {
  double mass_kg{};
  rt::Vector3 inertia_kg_m2;
  std::uint32_t rotors{};
  UavRotor rotor[rt::kMaxRotors]{};
  double thrust_n_s2{};  ///< k_f
  double moment_m{};     ///< k_m
  double tau_up_s{};     ///< lag of a rotor that speeds up
  double tau_down_s{};   ///< and of one that slows down
  double max_speed_rad_s{};
  double gravity_m_s2{9.81};

  /// Largest thrust of one rotor, N.
  double max_thrust_n() const { return thrust_n_s2 * max_speed_rad_s * max_speed_rad_s; }
};

/// not_finite or out_of_range when the model cannot fly: any value at or below zero, fewer than four rotors,
/// or less thrust than weight.
[[nodiscard]] Status check(const UavModel& model);

/// `rotors` on a regular polygon, the first at `first_rad` from the nose, signs taking turns from +.
void place_rotors(UavModel& model, std::uint32_t rotors, double arm_m, double first_rad);

}  // namespace sortie::planner
