// SPDX-License-Identifier: BSD-3-Clause
// What the task `recognise_images` puts out.
#pragma once

#include <cstdint>

#include "firmware_like/parts/recognise_output.hpp"
#include "mapping/recognition/image_search.hpp"

namespace sortie::firmware {

/// Images of the robot's own local map.
struct ImageDrawCounts {
  std::uint64_t drawn{};
  std::uint64_t floorless{};  ///< no floor below the robot: no image
  SORTIE_FIELDS(drawn, floorless)
};

/// The newest answer that is whole, and counts of all. Every verdict but kNone has kByImages in it.
struct RecogniseImagesOutput : rt::RecognisedPlace {
  std::uint64_t units{};   ///< of work so far
  std::uint32_t images{};  ///< that this run has kept
  ImageDrawCounts draws;
  mapping::ImageSearchCounts searches;
  RecogniseCounts counts;
  SORTIE_FIELDS(stamp_ns, verdict, p_known_odom_m, q_known_odom, covariance, speaking, pairs, agree, rival,
                rms_m, spread_m, proved, share, crossed, units, images, draws, searches, counts)
};

/// As a message has it that only images made.
inline std::uint8_t by_images(std::uint8_t verdict) {
  return static_cast<std::uint8_t>(verdict + rt::RecognisedPlace::kByImages);
}

/// A search's verdict as the message has it; of a place that no scan was held against.
inline std::uint8_t verdict_of(mapping::ImageVerdict verdict) {
  switch (verdict) {
    case mapping::ImageVerdict::none:
      return rt::RecognisedPlace::kNone;
    case mapping::ImageVerdict::found:
      return by_images(rt::RecognisedPlace::kUnverified);
    case mapping::ImageVerdict::few:
      return by_images(rt::RecognisedPlace::kFew);
    case mapping::ImageVerdict::unlike:
      return by_images(rt::RecognisedPlace::kInconsistent);
    case mapping::ImageVerdict::narrow:
      return by_images(rt::RecognisedPlace::kNarrow);
    case mapping::ImageVerdict::ambiguous:
      return by_images(rt::RecognisedPlace::kAmbiguous);
    case mapping::ImageVerdict::undecided:
      return by_images(rt::RecognisedPlace::kUndecided);
  }
  return rt::RecognisedPlace::kNone;
}

/// What a search came to, of an image that was drawn at `stamp_ns`; without what a scan says.
/// `T_known_odom`: of the best place, if there is one.
inline void put_answer(RecogniseImagesOutput& output, const mapping::ImageSearch& search,
                       std::uint32_t compared, const mapping::RigidPose& T_known_odom,
                       rt::Nanoseconds stamp_ns) {
  // A cell of an image and a fine turn: a place is told no finer, and nobody has measured how much better it
  // is.
  constexpr double kSigma[4] = {0.2, 0.2, 0.2, 0.0123};
  const auto found = search.found();
  output.stamp_ns = stamp_ns;
  output.verdict = verdict_of(search.verdict());
  rt::store(T_known_odom.p, output.p_known_odom_m);
  rt::store(T_known_odom.q, output.q_known_odom);
  for (int i = 0; i < 16; ++i) output.covariance[i] = 0.0;
  for (int i = 0; i < 4; ++i) output.covariance[5 * i] = found.empty() ? 0.0 : kSigma[i] * kSigma[i];
  const auto cells = [&found](std::size_t i) {
    return i < found.size() ? static_cast<std::uint32_t>(std::max(found[i].score.total(), 0)) : 0u;
  };
  output.speaking = search.cells();
  output.pairs = compared;
  output.agree = cells(0);
  output.rival = cells(1);
  output.share = output.crossed = 0.0;
}

}  // namespace sortie::firmware
