// SPDX-License-Identifier: BSD-3-Clause
// How well a scan lies on the map at a pose: by its returns, and by the rays that led to them.
#pragma once

#include <cstdint>
#include <span>

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/registration/scan_sample.hpp"
#include "mapping/registration/surfel_layer.hpp"
#include "rt/describe.hpp"

namespace sortie::mapping {

/// Shares of a sample's returns.
struct MatchScore {
  double value{};  ///< sum of 1 / (1 + d^4 / 9) over the returns, d in standard deviations, over their number
  double matched{};  ///< within three standard deviations of the surface in their cell
  double known{};    ///< in a cell that has a surface
  SORTIE_FIELDS(value, matched, known)
};

/// The score of a sample. `sigma_m`: what a surface is uneven by, beside its own spread. A look-up a return.
MatchScore match_score(const SurfelLayer& layer, std::span<const SamplePoint> sample, const RigidPose& pose,
                       double sigma_m);

/// How many of `rays` rays (of all, where the sample has fewer), evenly from the sample, go through a flat
/// surface of the map on their way to their return. Each is looked at from 1.5 cells before the sensor to 1.5
/// cells before its return, at most `most_steps` half cells of it: a look-up each.
std::uint32_t rays_through_surfaces(const SurfelLayer& layer, std::span<const SamplePoint> sample,
                                    const RigidPose& pose, std::uint32_t rays, std::uint32_t most_steps);

}  // namespace sortie::mapping
