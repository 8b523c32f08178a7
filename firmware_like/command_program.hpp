// SPDX-License-Identifier: BSD-3-Clause
// What every program of ours does around its commands: reads what was typed, runs the chosen one, and turns
// what went wrong into one line and an exit code.
#pragma once

#include <functional>
#include <string>

#include "firmware_like/scene/command_line.hpp"

namespace sortie::firmware {

/// Declares the commands below `root`; the one that was typed sets `chosen` to what it does.
using AddCommands = std::function<void(Command& root, std::function<int()>& chosen)>;

/// Runs the command line of the program `name` and returns the exit code: 0 good, 1 a check failed, 2 usage,
/// 3 input unreadable or corrupt, 4 platform refused. Never throws.
int run_commands(int argc, char** argv, const std::string& name, const AddCommands& add);

}  // namespace sortie::firmware
