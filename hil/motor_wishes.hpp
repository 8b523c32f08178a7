// SPDX-License-Identifier: BSD-3-Clause
// What simulated drives on a bus ask of the vehicle's motors, whatever their protocol.
#pragma once

#include <array>

#include "hil/vehicle_body.hpp"
#include "rt/samples.hpp"

namespace sortie::hil {

/// Of one step.
struct MotorWishes {
  std::array<double, 2> track_m_s{};  ///< left, right
  std::array<bool, 2> track_on{};     ///< under torque; else it coasts
  bool flippers{};                    ///< the vehicle has such drives
  std::array<double, rt::kFlippers> angle_rad{};
  std::array<bool, rt::kFlippers> moves{};  ///< under torque; else its brake holds it
};

/// Tells the body. A pair of flippers moves while both of its drives do.
void tell_body(VehicleBody& body, const MotorWishes& wishes, rt::Nanoseconds now_ns) noexcept;

}  // namespace sortie::hil
