// SPDX-License-Identifier: BSD-3-Clause
// What the task `recognise` puts out.
#pragma once

#include <cstdint>

#include "mapping/recognition/recogniser.hpp"
#include "rt/describe.hpp"
#include "rt/recognised_place.hpp"

namespace sortie::firmware {

/// Answers by what became of them.
struct RecogniseCounts {
  std::uint64_t recognised{};
  std::uint64_t unverified{};
  std::uint64_t refused{};  ///< by the scan
  SORTIE_FIELDS(recognised, unverified, refused)
};

struct RecogniseOutput : rt::RecognisedPlace {
  std::uint64_t units{};    ///< of work so far
  std::uint32_t targets{};  ///< that this run has made
  std::uint32_t key_frames{};
  mapping::RecogniserCounts searches;
  RecogniseCounts counts;
  SORTIE_FIELDS(stamp_ns, verdict, p_known_odom_m, q_known_odom, covariance, speaking, pairs, agree, rival,
                rms_m, spread_m, proved, share, crossed, units, targets, key_frames, searches, counts)
};

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

}  // namespace sortie::firmware
