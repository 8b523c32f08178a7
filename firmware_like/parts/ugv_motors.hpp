// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's motors as the profile names them, with their counters.
#pragma once

#include <memory>

#include "drivers/ugv_drives.hpp"
#include "firmware_like/parts/motors_config.hpp"
#include "firmware_like/runtime/vehicle.hpp"

namespace sortie::firmware {

/// Throw std::runtime_error where a setting cannot be used. Set-up only.
std::unique_ptr<drivers::UgvDrives> make_canopen(VehicleBuilder& builder,
                                                 const drivers::canopen::UgvNodesConfig& config);
std::unique_ptr<drivers::UgvDrives> make_odrive(VehicleBuilder& builder,
                                                const drivers::odrive::UgvAxesConfig& config);

}  // namespace sortie::firmware
