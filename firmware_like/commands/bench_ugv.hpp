// SPDX-License-Identifier: BSD-3-Clause
// The simulated robots as something that `run` can be driven against.
#pragma once

#include "firmware_like/bench_robot.hpp"

namespace sortie::firmware {

/// Makes the robot of [hil] for vehicle "ugv" or "uav": plant, sensors and CAN bus. Null if the profile has
/// no [hil].
std::unique_ptr<BenchRobot> make_own_bench(Profile& profile, drivers::ScanSink* scans);

}  // namespace sortie::firmware
