// SPDX-License-Identifier: BSD-3-Clause
// The ground robot's motors as the [drives] table of a profile names them, with their counters.
#pragma once

#include <memory>
#include <optional>

#include "drivers/canopen/ugv_nodes.hpp"
#include "drivers/odrive/ugv_axes.hpp"
#include "drivers/ugv_drives.hpp"
#include "firmware_like/runtime/vehicle.hpp"

namespace sortie::firmware {

/// One of them, or neither: then the motors speak the robot's own frames.
struct MotorsConfig {
  std::optional<drivers::canopen::UgvNodesConfig> canopen;
  std::optional<drivers::odrive::UgvAxesConfig> odrive;
};

/// What [drives] says. `flippers`: the robot has such motors. Throws ProfileError.
MotorsConfig read_motors(Profile& profile, bool flippers);

/// Throw std::runtime_error where a setting cannot be used. Set-up only.
std::unique_ptr<drivers::UgvDrives> make_canopen(VehicleBuilder& builder,
                                                 const drivers::canopen::UgvNodesConfig& config);
std::unique_ptr<drivers::UgvDrives> make_odrive(VehicleBuilder& builder,
                                                const drivers::odrive::UgvAxesConfig& config);

}  // namespace sortie::firmware
