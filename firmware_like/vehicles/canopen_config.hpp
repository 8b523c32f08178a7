// SPDX-License-Identifier: BSD-3-Clause
// The [drives] table of a profile: what the drives speak, and their numbers on the bus.
#pragma once

#include <optional>

#include "drivers/canopen/ugv_drives.hpp"
#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// What [drives] says; empty: the drives speak the robot's own frames. `flippers`: the robot has such drives.
/// Throws ProfileError.
std::optional<drivers::canopen::UgvDrivesConfig> read_canopen(Profile& profile, bool flippers);

}  // namespace sortie::firmware
