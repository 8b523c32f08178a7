// SPDX-License-Identifier: BSD-3-Clause
// The simulated multirotor as something that `run` can be driven against.
#pragma once

#include "firmware_like/bench_robot.hpp"

namespace sortie::firmware {

/// Makes the multirotor of [hil] for vehicle "uav": plant, sensors, world, CAN bus, and a lidar that
/// delivers to `scans`, which may be null. Throws ProfileError.
std::unique_ptr<BenchRobot> make_uav_bench(Profile& profile, drivers::ScanSink* scans);

}  // namespace sortie::firmware
