// SPDX-License-Identifier: BSD-3-Clause
// Written by toolchain/scene-builds --parts. Sizes move with every change of the code; what a part weighs
// hardly does.
#include "firmware_like/bench/part_sizes.hpp"

namespace sortie::firmware {

namespace {

// clang-format off
constexpr PartSize kPartSizes[] = {
    {"imu_bench", "", 2453362},
    {"imu_bench", "attitude", 2255318},
    {"skid_outdoor", "", 2570060},
    {"skid_outdoor", "attitude+odometry", 2255414},
    {"skid_outdoor", "odometry", 2453490},
    {"skid_outdoor", "recorder", 2555444},
    {"skid_outdoor", "telemetry", 2481533},
    {"uav_corridor", "", 2764903},
    {"uav_corridor", "path", 2628208},
    {"uav_corridor", "pilot+path", 2382170},
    {"uav_corridor", "recorder", 2750291},
    {"uav_corridor", "telemetry", 2676372},
    {"ugv_hall", "", 2976598},
    {"ugv_hall", "attitude+odometry+drive", 2577874},
    {"ugv_hall", "drive", 2834972},
    {"ugv_hall", "map", 2713726},
    {"ugv_hall", "odometry+drive", 2725810},
    {"ugv_hall", "recorder", 2962014},
    {"ugv_hall", "segment_lists", 2961738},
    {"ugv_hall", "segments", 2908866},
    {"ugv_hall", "telemetry", 2888023},
};
// clang-format on

}  // namespace

std::span<const PartSize> part_sizes() { return kPartSizes; }

}  // namespace sortie::firmware
