// SPDX-License-Identifier: BSD-3-Clause
// The `sortie` command line as a library: a robot engineer's own program gives it vehicles and gets every
// command.
#pragma once

#include <string>

#include "firmware_like/runtime/factories.hpp"

namespace sortie::toolchain {

/// What a program is made of.
struct ProgramParts {
  std::string name{"sortie"};
  firmware::VehicleRegistry vehicles;
  firmware::SimulatorFactory simulator;  ///< simulated robots for `run`, or null
};

/// Runs the command line and returns the exit code: 0 good, 1 a check failed, 2 usage, 3 input unreadable or
/// corrupt, 4 platform refused. Never throws.
int run_program(int argc, char** argv, const ProgramParts& parts);

}  // namespace sortie::toolchain
