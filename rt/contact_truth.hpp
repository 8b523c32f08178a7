// SPDX-License-Identifier: BSD-3-Clause
// What touches a vehicle, as only a simulation knows it. For judging; never an input of any task.
#pragma once

#include "rt/fixed_vector.hpp"
#include "rt/samples.hpp"

namespace sortie::rt {

/// The parts of a tracked vehicle with flippers.
enum class VehiclePart : std::uint8_t {
  body,
  track_left,
  track_right,
  flipper_front_left,
  flipper_front_right,
  flipper_rear_left,
  flipper_rear_right,
};
inline constexpr std::uint32_t kVehicleParts = 7;
/// Their names in tables and plots, in that order.
inline constexpr const char* kVehiclePartNames[kVehicleParts] = {
    "body",
    "track_left",
    "track_right",
    "flipper_front_left",
    "flipper_front_right",
    "flipper_rear_left",
    "flipper_rear_right",
};

/// One contact, in body axes (x forward, y left, z up). Impulses are on the vehicle, over one step.
struct TruthContact {
  VehiclePart part{};
  double point_m[3]{};               ///< from the body's place, the one that TruthSample gives
  double normal[3]{};                ///< unit, out of the obstacle into the vehicle
  double normal_impulse_n_s{};       ///< along the normal, not negative
  double friction_impulse_n_s[3]{};  ///< across it
  double penetration_m{};            ///< negative: the gap that the step would have closed
};

/// Contacts and flippers at one time. Angles and torques as in FlipperSample. About 6 kB.
struct ContactTruth {
  static constexpr std::uint32_t kMaxContacts = 64;

  Nanoseconds stamp_ns{};  ///< end of the step whose contacts these are; the axes are those at its begin
  Nanoseconds step_ns{};   ///< impulse / step = force
  double flipper_asked_rad[kFlippers]{};
  double flipper_angle_rad[kFlippers]{};
  double flipper_torque_n_m[kFlippers]{};
  std::uint32_t dropped{};  ///< contacts that there was no room for
  FixedVector<TruthContact, kMaxContacts> contacts;

  /// Contacts of a part. Cost: one pass.
  std::uint32_t count(VehiclePart part) const {
    std::uint32_t n = 0;
    for (const TruthContact& contact : contacts) n += contact.part == part ? 1 : 0;
    return n;
  }
};

}  // namespace sortie::rt
