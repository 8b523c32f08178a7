// SPDX-License-Identifier: BSD-3-Clause
// Written by toolchain/scene-builds --parts. Sizes move with every change of the code; what a part weighs
// hardly does.
#include "firmware_like/bench/part_sizes.hpp"

namespace sortie::firmware {

namespace {

constexpr PartSize kPartSizes[] = {
    {"ugv_hall", "", 2795354},
};

}  // namespace

std::span<const PartSize> part_sizes() { return kPartSizes; }

}  // namespace sortie::firmware
