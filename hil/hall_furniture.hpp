// SPDX-License-Identifier: BSD-3-Clause
// Random furniture of the hall: a seed decides what stands where; the robot's way stays free.
#pragma once

#include "hil/hall.hpp"

namespace sortie::hil {

/// Tries config.furniture pieces at random places of the hall and adds those that keep their distance from
/// the path and from what is already there. Leaves the world unfinalized. The `solids` of the report is not
/// filled.
HallReport add_furniture(const HallConfig& config, World& world);

/// Distance in metres from a point to the polyline that is kept free; infinity if there is none.
double distance_to_path(const HallConfig& config, double x_m, double y_m);

}  // namespace sortie::hil
