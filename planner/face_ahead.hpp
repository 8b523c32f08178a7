// SPDX-License-Identifier: BSD-3-Clause
// Whether a vehicle runs its nose into a face that is too high to be climbed. A posture does not know: it
// lets the vehicle down from above.
#pragma once

#include "planner/posture.hpp"

namespace sortie::planner {

/// True where within `advance_m` of a place a face, steeper than 65 degrees, meets the leading flippers or
/// tracks above where their outline is no steeper than `climb_rad`: the vehicle would
/// push, not climb. `posture` is the one at the place that `solver` has looked at; it moves on along its own
/// slope. `direction` is -1 where it drives backward. Mirrored alike. Cost: a few columns of four rows, below
/// 1 us.
bool is_face_ahead(const PostureSolver& solver, const FlipperSet& flippers, const Posture& posture,
                   double direction, double advance_m, double climb_rad);

}  // namespace sortie::planner
