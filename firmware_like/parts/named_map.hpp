// SPDX-License-Identifier: BSD-3-Clause
// The kept map that a profile names.
#pragma once

#include "firmware_like/runtime/kept_map.hpp"
#include "firmware_like/runtime/vehicle_builder.hpp"

namespace sortie::firmware {

/// The map that the run begins with, for the part whose keys are in `table` ("locate", "join"); null where
/// there is none. Reads TABLE.map and TABLE.map_digest, in which `--map` has written which one it is. Throws
/// ProfileError where the profile names a map that is not there, or another one.
const KeptMap* named_map(VehicleBuilder& builder, const std::string& table);

}  // namespace sortie::firmware
