// SPDX-License-Identifier: BSD-3-Clause
// Written by toolchain/scene-builds --parts. Sizes move with every change of the code; what a part weighs
// hardly does.
#include "firmware_like/bench/part_sizes.hpp"

namespace sortie::firmware {

namespace {

// clang-format off
constexpr PartSize kPartSizes[] = {
    {"uav_corridor", "", 2739370},
    {"uav_corridor", "path", 2602675},
    {"ugv_hall", "", 2951065},
    {"ugv_hall", "drive", 2809455},
    {"ugv_hall", "map", 2688197},
    {"ugv_hall", "segment_lists", 2936189},
    {"ugv_hall", "segments", 2883333},
};
// clang-format on

}  // namespace

std::span<const PartSize> part_sizes() { return kPartSizes; }

}  // namespace sortie::firmware
