// SPDX-License-Identifier: BSD-3-Clause
// Settings of the registration of two sets of planes, and the most that it works with.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_fit.hpp"

namespace sortie::mapping {

/// Gates are for the search; what is accepted in the end is decided by the planes' own errors and by
/// evidence: the logarithm of how much likelier the matches are at this place than by chance, less that of
/// the number of places looked at.
struct PlaneRegistrationConfig {
  double most_angle_rad{0.14};       ///< between normals that may match
  double most_area_ratio{20};        ///< between areas that may match
  double overlap_margin_m{0.3};      ///< rectangles this far apart still overlap
  double search_gate_m{0.3};         ///< distance of planes that may match before the fit
  double sigmas{3.5};                ///< distance, and angle, of planes that match after it
  double share_matched{0.6};         ///< of the planes seen by both maps, expected
  double least_evidence{15};         ///< below it a place is refused,
  double evidence_per_plane{1.6};    ///< and below this much a plane that both maps should see
  double most_mirrored{0.9};         ///< evidence of a mirror image over the best place's, above it ambiguous
  double most_mirrored_known{1.25};  ///< the same where position and yaw are known
  double most_runner_up{0.6};        ///< evidence of another place over the best one's: above it, ambiguous
  double least_margin{4};            ///< and the least difference between the two
  double least_share{0.4};           ///< matches over the planes of the smaller set within the other's bounds
  std::uint32_t least_matches{4};    ///< below it a place is refused
  double most_area_ratio_alone{1.5};  ///< between areas of a pair that alone holds a direction: else refused
  double basin_m{0.15};               ///< places this near, and
  double basin_rad{0.03};             ///< turned by no more than this, are one place
  bool signed_normals{true};          ///< normals point to where they were seen from, in both sets
  PlaneFitConfig fit;
};

/// Most hypotheses of a place that are looked at, turns that are tried, and pairs of planes under one turn.
inline constexpr std::uint32_t kMostHypotheses = 4096;
inline constexpr std::uint32_t kMostTurns = 24;
inline constexpr std::uint32_t kMostCandidatePairs = 16384;

}  // namespace sortie::mapping
