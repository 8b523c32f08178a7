// SPDX-License-Identifier: BSD-3-Clause
// How well a match is known.
#pragma once

#include "mapping/registration/weak_directions.hpp"

namespace sortie::mapping {

/// Covariance of (turn, move) along the map's axes, with the prior: what the residuals scatter by, what
/// starts about the pose ended apart (`spread`), and what all scans of a place share (Brossard et al. 2020).
/// Along weak directions it is the prior's. False, and nothing is written, where nothing holds the pose.
bool match_covariance(const NormalEquations& equations, const WeakDirections& weak, const PosePrior& prior,
                      const double (&spread)[6][6], double (&covariance)[6][6]);

/// The same of (position in map, rotation in sensor), row-major: of a covariance of (turn, move) along the
/// map's axes about a pose of rotation `q_map_sensor`.
void pose_covariance(const double (&covariance)[6][6], const rt::Quaternion& q_map_sensor, double (&out)[36]);

}  // namespace sortie::mapping
