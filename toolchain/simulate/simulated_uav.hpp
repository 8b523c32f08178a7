// SPDX-License-Identifier: BSD-3-Clause
// The simulated multirotor as something that `run` can be driven against.
#pragma once

#include "firmware_like/live/simulated_robot.hpp"

namespace sortie::toolchain {

/// Makes the multirotor of [hil] for vehicle "uav": plant, sensors, world, CAN bus, and a lidar that
/// delivers to `scans`, which may be null. Throws ProfileError.
std::unique_ptr<firmware::SimulatedRobot> make_simulated_uav(firmware::Profile& profile,
                                                             drivers::ScanSink* scans);

}  // namespace sortie::toolchain
