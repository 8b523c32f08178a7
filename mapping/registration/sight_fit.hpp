// SPDX-License-Identifier: BSD-3-Clause
// The pose, and the scale, at which the cells of one cloud lie best on the surfaces of another.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/registration/plane_pose.hpp"
#include "mapping/registration/sight_layer.hpp"
#include "mapping/registration/sight_score.hpp"

namespace sortie::mapping {

/// A fit, and how well it is held.
struct SightFit {
  PlanePose T_target_source;
  double sigma_m{1e9};    ///< of the middle of the source's cells, in the direction that is held least
  double sigma_rad{1e9};  ///< of the turn about the axis that is held least
  std::uint32_t pairs{};  ///< cells that lay on a surface in the last step
};

/// Gauss-Newton over the distances of cells from the planes of the surfaces that they lie on, as seen from
/// where they are now; each step with a narrower gate, from 0.25 m on, and Tukey's weights. The vertical is
/// the estimate's, where it has one, and the scale changes only where the estimate leaves it open. Every
/// `stride`-th cell of the source takes part. Neighbouring cells err together: ten of them count as one.
/// Deterministic. About 4 look-ups a cell and step.
SightFit fit_sights(std::span<const SightCell> source, const SightLayer& target, const PlanePose& start,
                    const PlaneEstimate& estimate, const SightGates& gates, int steps, std::uint32_t stride);

}  // namespace sortie::mapping
