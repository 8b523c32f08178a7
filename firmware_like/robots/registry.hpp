// SPDX-License-Identifier: BSD-3-Clause
// The vehicles that this program knows by name.
#pragma once

#include "firmware_like/runtime/factories.hpp"

namespace sortie::firmware {

/// Vehicles of the program itself: "ugv" and "uav", or the one of the scene that it was built for.
VehicleRegistry own_vehicles();

}  // namespace sortie::firmware
