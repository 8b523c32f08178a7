// SPDX-License-Identifier: BSD-3-Clause
// Rotations that may take one set of planes into the other, from their normals alone.
#pragma once

#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/plane_registration_config.hpp"
#include "mapping/registration/plane_side.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// A rotation and how much spoke for it.
struct PlaneTurn {
  rt::Quaternion q_target_source;
  double votes{};
};
using PlaneTurns = rt::FixedVector<PlaneTurn, kMostTurns>;

/// With gravity: differences of walls' directions vote by degrees; at most 8 peaks. With a known yaw none
/// beyond 4 sigma (and 3 degrees) of it. Without gravity: every two of the 12 largest source planes, and
/// every two of the 16 largest target planes with the same angle between them (20 to 160 degrees, within 5),
/// give one rotation; those within 4 degrees of each other are one; at most 24, by votes. Most votes first;
/// where none is found, the estimate's rotation alone. Cost: one look a pair of walls; without gravity about
/// 16,000 looks and 0.3 ms.
void find_turns(const PlaneSide& source, const PlaneSide& target, const PlaneEstimate& estimate,
                const PlaneRegistrationConfig& config, PlaneTurns& turns);

}  // namespace sortie::mapping
