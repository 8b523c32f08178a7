// SPDX-License-Identifier: BSD-3-Clause
// The segments of a local map as they cross rooms: a bounded list, and the events of their lives.
#pragma once

#include <cstdint>

#include "rt/describe.hpp"
#include "rt/time.hpp"

namespace sortie::rt {

/// One segment. Places are relative to the list's origin, in the world's frame.
struct ListedSegment {
  static constexpr std::uint32_t kFeatures = 7;
  std::uint32_t id{};
  std::uint32_t voxels{};
  // Zero in a list without features.
  float centroid_m[3]{};
  float least_m[3]{};  ///< corners of the box around the voxels' means
  float most_m[3]{};
  float feature[kFeatures]{};  ///< linearity, planarity, scattering, omnivariance, anisotropy, eigenentropy,
                               ///< change of curvature
};

/// What happened to a segment.
enum class SegmentChange : std::uint8_t {
  born,     ///< `id` is new; `other` is the segment that it was cut from, or 0
  renamed,  ///< `id` was joined into the older `other`
  gone,     ///< nothing of `id` is left in the local map
};

/// One event in the life of a segment.
struct SegmentEvent {
  SegmentChange change{};
  std::uint32_t id{};
  std::uint32_t other{};
  SORTIE_FIELDS(change, id, other)
};

/// A map's segments after a scan: at most kMost of them and kMostEvents events, so that the message stays
/// below one datagram's 16 KiB. About 12 kB.
struct SegmentList {
  static constexpr std::uint32_t kMost = 128;
  static constexpr std::uint32_t kMostEvents = 256;
  Nanoseconds stamp_ns{};    ///< of the scan
  std::uint32_t segments{};  ///< in the map, listed or not
  std::uint32_t events{};    ///< since the list before, listed or not
  double origin_m[3]{};      ///< of the places
  bool features{};
  std::uint32_t listed{};
  std::uint32_t listed_events{};
  ListedSegment segment[kMost];
  SegmentEvent event[kMostEvents];
};

}  // namespace sortie::rt
