// SPDX-License-Identifier: BSD-3-Clause
// Simulated drives for a sweep without a log of its own.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/runtime/kept_map.hpp"
#include "toolchain/commands/commands.hpp"

namespace sortie::toolchain {

/// What to simulate.
struct DriveRequest {
  std::vector<std::string> scenes;
  std::vector<std::string> overrides;
  firmware::KeptMapPaths maps;  ///< that they begin with
  double seconds{10};
  std::uint32_t seeds{1};  ///< drives of each scene; more than one: with hil.seed = 1, 2, ...
};

/// A recorded drive.
struct SimulatedDrive {
  std::string log;
  std::string identity;  ///< digest of program, profile and length: the same on every machine
};

/// Simulates the drives into `folder`; a drive of the same identity that is there already is kept. Throws
/// ProfileError, InputError.
std::vector<SimulatedDrive> simulate_drives(const CommandContext& context, const DriveRequest& request,
                                            const std::string& folder);

}  // namespace sortie::toolchain
