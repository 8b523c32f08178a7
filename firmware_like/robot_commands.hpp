// SPDX-License-Identifier: BSD-3-Clause
// The commands of the small program that a robot carries: drive, and prove what was driven.
#pragma once

#include <functional>

#include "firmware_like/runtime/factories.hpp"
#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// Declares `run`, `replay`, `check` and `doctor` below `root`. `vehicles` and `chosen` outlive them.
void add_robot_commands(Command& root, const VehicleRegistry& vehicles, std::function<int()>& chosen);

}  // namespace sortie::firmware
