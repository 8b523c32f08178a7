// SPDX-License-Identifier: BSD-3-Clause
// What a program is made of; the commands are the same in all.
#pragma once

#include <string>

#include "firmware_like/runtime/factories.hpp"

namespace sortie::toolchain {

/// Its name, vehicles and simulated robots.
struct ProgramParts {
  std::string name{"sortie"};
  firmware::VehicleRegistry vehicles;
  firmware::SimulatorFactory simulator;  ///< simulated robots for `run`, or null
};

}  // namespace sortie::toolchain
