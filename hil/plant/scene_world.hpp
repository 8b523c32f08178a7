// SPDX-License-Identifier: BSD-3-Clause
// What a plant stands on, as the world that rays see: the same solids to the last digit.
#pragma once

#include "hil/plant/plant_scene.hpp"
#include "hil/world.hpp"

namespace sortie::hil {

/// Adds every solid of the scene to a world, which finalize() must follow. Half-spaces are left to the
/// caller: a world has its ground at z = 0 and no other. Status: ok; that of World::add(), not_supported for
/// a body that is neither box nor cylinder; solids added before a refusal stay.
Status add_to_world(const PlantScene& scene, World& world, std::uint16_t reflectivity = 100);

}  // namespace sortie::hil
