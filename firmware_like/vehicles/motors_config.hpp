// SPDX-License-Identifier: BSD-3-Clause
// The [drives] table of a profile: what the motors speak, and their numbers on the bus.
#pragma once

#include <optional>

#include "drivers/canopen/ugv_nodes.hpp"
#include "drivers/odrive/ugv_axes.hpp"
#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// One of them, or neither: then the motors speak the robot's own frames.
struct MotorsConfig {
  std::optional<drivers::canopen::UgvNodesConfig> canopen;
  std::optional<drivers::odrive::UgvAxesConfig> odrive;
};

/// What [drives] says. `flippers`: the robot has such motors. Throws ProfileError.
MotorsConfig read_motors(Profile& profile, bool flippers);

}  // namespace sortie::firmware
