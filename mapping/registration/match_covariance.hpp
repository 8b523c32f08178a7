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

}  // namespace sortie::mapping
