// SPDX-License-Identifier: BSD-3-Clause
// Obstacles of the published scenarios as boxes of a plant's scene: stairs, a pallet, a ramp, rubble.
#pragma once

#include <cstdint>

#include "hil/plant/plant_scene.hpp"

namespace sortie::hil {

/// Where an obstacle begins and which way it is driven: its first edge is met at `p_world_m` by a robot that
/// drives along the heading; its middle lies on that line.
struct Approach {
  Vec3 p_world_m;
  double yaw_rad{};
};

/// A flight of stairs.
struct StairShape {
  int steps{5};
  double run_m{0.28};
  double rise_m{0.17};
  double width_m{1.2};
  double landing_m{1.5};  ///< behind the last step; the flight stands on it, so that no box ends inside
};

/// Stairs up. Each box reaches from its riser to the end of the landing: treads have no inner edges. Status:
/// that of PlantScene; boxes added before a refusal stay.
Status add_stairs(PlantScene& scene, const Approach& where, const StairShape& shape);

/// A pallet of EUR size, 1.2 m across the way and 0.8 m along it, 0.133 m high: five boards of 22 mm with
/// gaps on three stringers, nine blocks, three runners. Status as above. 20 boxes.
Status add_pallet(PlantScene& scene, const Approach& where);

/// A ramp that rises at `slope_rad` over `length_m` of slope to a deck of `deck_m`. Status as above. 2 boxes.
Status add_ramp(PlantScene& scene, const Approach& where, double slope_rad, double length_m, double deck_m,
                double width_m);

/// A field of `count` blocks of 8 to 30 cm, turned and sunk into the ground at random, by the seed.
Status add_rubble(PlantScene& scene, const Approach& where, double length_m, double width_m, int count,
                  std::uint64_t seed);

}  // namespace sortie::hil
