// SPDX-License-Identifier: BSD-3-Clause
// The simulated robots as something that `run` can be driven against.
#pragma once

#include "firmware_like/live/simulated_robot.hpp"

namespace sortie::toolchain {

/// Makes the robot of [hil] for vehicle "ugv" or "uav": plant, sensors and CAN bus. Null if the profile has
/// no [hil].
std::unique_ptr<firmware::SimulatedRobot> make_simulated_robot(firmware::Profile& profile,
                                                               drivers::ScanSink* scans);

}  // namespace sortie::toolchain
