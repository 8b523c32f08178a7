// SPDX-License-Identifier: BSD-3-Clause
// The [drives] table of a profile: what the motors speak, and their numbers on the bus.
#pragma once

#include <optional>

#include "drivers/canopen/ugv_nodes.hpp"
#include "drivers/emergency_button.hpp"
#include "drivers/gpio_line.hpp"
#include "drivers/odrive/ugv_axes.hpp"
#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

/// One of them, or neither: then the motors speak the robot's own frames.
struct MotorsConfig {
  std::optional<drivers::canopen::UgvNodesConfig> canopen;
  std::optional<drivers::odrive::UgvAxesConfig> odrive;
};

/// Where an emergency stop is read: [emergency].
struct EmergencyConfig {
  drivers::EmergencyButtonConfig button;
  std::optional<drivers::GpioLineConfig> gpio;
};

/// What [emergency] says. Throws ProfileError.
EmergencyConfig read_emergency(Profile& profile);

/// What [drives] says. `flippers`: the robot has such motors. Throws ProfileError.
MotorsConfig read_motors(Profile& profile, bool flippers);

}  // namespace sortie::firmware
