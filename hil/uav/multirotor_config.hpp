// SPDX-License-Identifier: BSD-3-Clause
// Parameters of simulated multirotors, as the RotorS simulator describes them.
#pragma once

#include <cstdint>

#include "hil/geometry.hpp"

namespace sortie::hil {

inline constexpr std::uint32_t kMaxSimulatedRotors = 8;

/// One rotor: where it sits from the body's origin (x forward, y left, z up), and which way it turns seen
/// from above (+1 counter-clockwise).
struct SimulatedRotor {
  Vec3 place_m;
  double direction{1.0};
};

/// A battery behind the rotors: its voltage falls with charge and load, and without a speed loop the rotors
/// turn slower by the same share.
struct BatteryConfig {
  double capacity_as{0.0};      ///< charge; 0: an ideal source
  double full_v{16.8};          ///< open-circuit voltage when full, at which commands are met exactly
  double empty_v{13.2};         ///< the same when empty
  double resistance_ohm{0.02};  ///< inner resistance
  double efficiency{0.6};       ///< electric power to shaft power
  double start_charge{1.0};     ///< share of the charge at the start
  bool speed_loop{false};       ///< the speed controllers hold the speed; then only the ceiling falls
};

/// A vehicle in RotorS' terms. Masses and inertias of the frame are those of its xacro files; the
/// controllers' yaml files differ a little, which is a model error of the original that we keep.
struct MultirotorConfig {
  const char* name{""};
  double frame_mass_kg{1.0};
  double rotor_mass_kg{0.005};  ///< of each rotor, at its place
  Vec3 inertia_kg_m2{};         ///< of the frame, about its axes
  std::uint32_t rotors{6};
  SimulatedRotor rotor[kMaxSimulatedRotors]{};
  double thrust_n_s2{};  ///< k_f: thrust = k_f w^2
  double moment_m{};     ///< k_m: yaw torque = k_m thrust
  double tau_up_s{};     ///< time constant of a rotor that speeds up
  double tau_down_s{};   ///< and of one that slows down
  double max_speed_rad_s{};
  double drag_n_s2{};         ///< c_d: drag = |w| c_d v, across the rotor's axis
  double rolling_n_m_s2{};    ///< c_r: rolling moment = |w| c_r v, the same
  double gravity_m_s2{9.81};  ///< RotorS' world has 9.8, its controllers 9.81
  bool ground{true};          ///< the plane z = 0 catches the body's origin
  BatteryConfig battery;
};

/// The hexacopters that RotorS describes.
MultirotorConfig firefly_plant();
MultirotorConfig neo9_plant();
MultirotorConfig neo11_plant();

/// Mass with the rotors.
double total_mass_kg(const MultirotorConfig& config);
/// Inertia with the rotors' masses at their places. The shift of the centre of mass (0.25 mm) is left out.
Vec3 total_inertia_kg_m2(const MultirotorConfig& config);

}  // namespace sortie::hil
