// SPDX-License-Identifier: BSD-3-Clause
// What the rays of a scan say of a pose on a map: surfaces that they went through, and surfaces that they
// would have gone on to.
#pragma once

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/registration/surfel_layer.hpp"

namespace sortie::mapping {

/// Whether a ray of a sensor at `pose` to a return, `at` in the sensor's frame, goes through a flat surface
/// of the map on its way, at least a cell from either end. Small things count: it has to pass within a
/// standard deviation of a surface's middle, along it. At most 96 look-ups.
bool goes_through(const SurfelLayer& layer, const RigidPose& pose, const rt::Vector3& at);

/// Whether it would have met one behind its return, within four metres: the map has seen what lies there, so
/// that it knows the place of the return to be free unless it has a surface there. At most 16 look-ups.
bool is_before_surface(const SurfelLayer& layer, const RigidPose& pose, const rt::Vector3& at);

}  // namespace sortie::mapping
