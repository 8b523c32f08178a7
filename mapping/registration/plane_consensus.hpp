// SPDX-License-Identifier: BSD-3-Clause
// How much two sets of planes agree at one pose, judged by the planes' own errors.
#pragma once

#include <cstdint>

#include "mapping/registration/plane_candidates.hpp"
#include "rt/fixed_vector.hpp"

namespace sortie::mapping {

/// Pairs that a pose brings together. A plane of the source has one partner at most; several may share one of
/// the target: a wall in pieces.
using PlanePairs = rt::FixedVector<PlanePair, kMostPlanes>;

/// Agreement at a pose.
struct PlaneConsensus {
  double evidence{};         ///< sum of the best gain of each matched target plane, less the cost of misses
  std::uint32_t matched{};   ///< planes of the target that have a partner
  std::uint32_t expected{};  ///< planes of the smaller set within the other's box, or matched
  std::uint32_t missed{};    ///< those of them that have none
  double share() const { return expected > 0 ? 1.0 - static_cast<double>(missed) / expected : 0.0; }
};

/// Candidates that a fit may bring together, by their numbers.
using NearCandidates = rt::FixedVector<std::uint16_t, 4096>;

/// Matches every source plane with the candidate of `near` that gains most of those within `sigmas` of it in
/// distance and in tilt, and overlapping it. A match gains its worth less ln(standard deviation of its
/// distance) less half its squared residual in these, plus ln of twice the share of the smaller rectangle
/// that the other covers, less what unlike areas speak against it; a plane of the smaller set that lies
/// within the other set's box and has no partner costs -ln(1 - share_matched). `gains` has room for what each
/// of the pairs gains. Cost: a look a candidate, ~60 ns a match.
PlaneConsensus judge(const PlaneSide& source, const PlaneSide& target, const PlaneCandidates& candidates,
                     const NearCandidates& near, const PlanePose& pose, const PlaneRegistrationConfig& config,
                     PlanePairs& pairs, double* gains);

/// Only the pairs, for a first fit: of each source plane's candidates within the gates of distance and tilt
/// that overlap it the one that is least of both, in parts of these gates. `near` gets all candidates within
/// twice the distance, for what follows.
void pair_near(const PlaneSide& source, const PlaneSide& target, const PlaneCandidates& candidates,
               const PlanePose& pose, const PlaneRegistrationConfig& config, NearCandidates& near,
               PlanePairs& pairs);

}  // namespace sortie::mapping
