// SPDX-License-Identifier: BSD-3-Clause
// The upper surface of a plant's scene, and its mirror image.
#pragma once

#include "hil/plant/plant_scene.hpp"

namespace sortie::hil {

/// Height of the uppermost surface at (x, y), m, in closed form: of half-spaces that face up, of boxes in any
/// attitude, of cylinders that lie level. Minus infinity where nothing is. Throws std::runtime_error for a
/// solid of another kind. Cost: 1 ns a solid, 5 ns one that lies under the place.
double upper_height(const PlantScene& scene, double x_m, double y_m);

/// Adds to `out` every half-space and solid with y changed to -y. Status: that of PlantScene; what was added
/// before a refusal stays.
Status add_mirrored(const PlantScene& scene, PlantScene& out);

}  // namespace sortie::hil
