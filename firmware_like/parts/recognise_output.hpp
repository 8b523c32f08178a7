// SPDX-License-Identifier: BSD-3-Clause
// What the task `recognise` puts out.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "mapping/grid/rolling_grid_config.hpp"
#include "mapping/recognition/recogniser.hpp"
#include "rt/describe.hpp"
#include "rt/recognised_place.hpp"
#include "rt/rotation.hpp"

namespace sortie::firmware {

/// Answers by what became of them, and what a lost robot was told.
struct RecogniseCounts {
  std::uint64_t recognised{};
  std::uint64_t unverified{};
  std::uint64_t refused{};        ///< by the scan
  std::uint64_t placed{};         ///< places that a lost robot was told
  std::uint64_t not_confirmed{};  ///< of them, that no scan confirmed
  SORTIE_FIELDS(recognised, unverified, refused, placed, not_confirmed)
};

/// The newest answer that is whole, and counts of all.
struct RecogniseOutput : rt::RecognisedPlace {
  std::uint64_t units{};    ///< of work so far
  std::uint32_t targets{};  ///< that this run has made
  std::uint32_t key_frames{};
  mapping::RecogniserCounts searches;
  RecogniseCounts counts;
  SORTIE_FIELDS(stamp_ns, verdict, p_known_odom_m, q_known_odom, covariance, speaking, pairs, agree, rival,
                rms_m, spread_m, proved, share, crossed, units, targets, key_frames, searches, counts)
};

/// A search's verdict as the message has it; of a place that no scan was held against.
inline std::uint8_t verdict_of(mapping::SetVerdict verdict) {
  switch (verdict) {
    case mapping::SetVerdict::none:
      return rt::RecognisedPlace::kNone;
    case mapping::SetVerdict::found:
      return rt::RecognisedPlace::kUnverified;
    case mapping::SetVerdict::few:
      return rt::RecognisedPlace::kFew;
    case mapping::SetVerdict::inconsistent:
      return rt::RecognisedPlace::kInconsistent;
    case mapping::SetVerdict::bent:
      return rt::RecognisedPlace::kBent;
    case mapping::SetVerdict::narrow:
      return rt::RecognisedPlace::kNarrow;
    case mapping::SetVerdict::ambiguous:
      return rt::RecognisedPlace::kAmbiguous;
    case mapping::SetVerdict::undecided:
      return rt::RecognisedPlace::kUndecided;
  }
  return rt::RecognisedPlace::kNone;
}

/// T_known_odom; half the turn from its cosine and sine.
inline mapping::RigidPose pose_of(const mapping::LevelPlace& place) {
  const double cosine = std::sqrt(std::max(0.5 * (1.0 + place.cosine), 0.0));
  const double sine = std::sqrt(std::max(0.5 * (1.0 - place.cosine), 0.0));
  return {{place.x_m, place.y_m, place.z_m}, rt::normalised({cosine, 0, 0, place.sine < 0.0 ? -sine : sine})};
}

/// What a search came to, of segments that were looked at at `stamp_ns`; without what a scan says.
inline void put_answer(RecogniseOutput& output, const mapping::Recogniser& recogniser,
                       rt::Nanoseconds stamp_ns) {
  constexpr double kLeastSigma = 0.05;  // m: of a target's place
  const auto found = recogniser.found();
  const mapping::LevelFit fit = found.empty() ? mapping::LevelFit{} : found[0].fit;
  output.stamp_ns = stamp_ns;
  output.verdict = verdict_of(recogniser.verdict());
  const mapping::RigidPose pose = pose_of(fit.place);
  rt::store(pose.p, output.p_known_odom_m);
  rt::store(pose.q, output.q_known_odom);
  const auto covariance = mapping::level_covariance(fit, std::max(fit.rms_m, kLeastSigma));
  std::copy(covariance.begin(), covariance.end(), output.covariance);
  output.speaking = static_cast<std::uint32_t>(recogniser.segments().size());
  output.pairs = static_cast<std::uint32_t>(recogniser.pairs().size());
  output.agree = found.empty() ? 0 : found[0].count;
  output.rival = found.size() < 2 ? 0 : found[1].count;
  output.rms_m = fit.rms_m;
  output.spread_m = fit.spread_m;
  output.proved = recogniser.proved();
  output.share = output.crossed = 0.0;
}

}  // namespace sortie::firmware
