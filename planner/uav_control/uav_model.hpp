// SPDX-License-Identifier: BSD-3-Clause
// What a flight controller believes about its vehicle.
#pragma once

#include <cstdint>

#include "rt/keys.hpp"
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

/// A vehicle as it is written: its rotors on a regular polygon. Unless it says otherwise it is the AscTec Neo
/// with propellers of 11 inches, as RotorS' controllers know it.
struct RegularMultirotor {
  UavModel model{.mass_kg = 3.42,  // but for `rotor`
                 .inertia_kg_m2 = {0.0608, 0.0688, 0.1489},
                 .rotors = 6,
                 .thrust_n_s2 = 1.269e-5,
                 .moment_m = 0.016754,
                 .tau_up_s = 0.0182,
                 .tau_down_s = 0.0182,
                 .max_speed_rad_s = 1047.2};
  double arm_m{0.2895};
  double first_rad{30 * rt::kDegInRad.kept};

  SORTIE_KEYS(c, key) {
    constexpr const char* kInertia = "moment of inertia of the whole vehicle";
    key("mass_kg", c.model.mass_kg, {0.05, 50, "kg", "of the whole vehicle"});
    key("inertia_xx_kg_m2", c.model.inertia_kg_m2.x, {1e-5, 50, "kg m2", kInertia});
    key("inertia_yy_kg_m2", c.model.inertia_kg_m2.y, {1e-5, 50, "kg m2", kInertia});
    key("inertia_zz_kg_m2", c.model.inertia_kg_m2.z, {1e-5, 50, "kg m2", kInertia});
    key("rotors", c.model.rotors,
        {4, rt::kMaxRotors, "", "in a regular ring, turning by turns left and right"});
    key("arm_m", c.arm_m, {0.02, 3, "m", "from the middle to a rotor"});
    key("first_rotor_deg", c.first_rad,
        {-360, 360, rt::kDegInRad, "of rotor 1, from ahead to the left; it turns left"});
    key("thrust_n_s2", c.model.thrust_n_s2, {1e-9, 1, "N s2", "thrust / square of the speed"});
    key("moment_m", c.model.moment_m, {1e-6, 1, "m", "yaw torque / thrust"});
    key("tau_up_ms", c.model.tau_up_s, {0.01, 500, rt::kMsInS, "lag of a rotor that speeds up"});
    key("tau_down_ms", c.model.tau_down_s, {0.01, 500, rt::kMsInS, "lag of a rotor that slows down"});
    key("max_rotor_rad_s", c.model.max_speed_rad_s, {10, 1310, "rad/s", "most that a rotor is asked for"});
  }
};

}  // namespace sortie::planner
