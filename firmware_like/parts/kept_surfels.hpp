// SPDX-License-Identifier: BSD-3-Clause
// A kept map of surfaces and the scene that is to begin with it.
#pragma once

#include "firmware_like/runtime/vehicle_builder.hpp"
#include "mapping/registration/locator.hpp"

namespace sortie::firmware {

/// Gives the locator the map that the run begins with, if the builder has one. Reads locate.map and
/// locate.map_digest, in which `--map` has written which one it is. Throws ProfileError where the profile
/// names a map that is not there, or another one; InputError, naming the cure, where the file does not fit.
void load_kept_map(VehicleBuilder& builder, mapping::Locator& locator);

}  // namespace sortie::firmware
