// SPDX-License-Identifier: BSD-3-Clause
// A visit's local map as it runs on board, and the segments that spoke in it.
#pragma once

#include <vector>

#include "mapping/recognition/segment_descriptor.hpp"
#include "mapping/segments/segment_features.hpp"
#include "tests/bench/recognition/thing_hall.hpp"
#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// How a map's voxels become segments.
enum class HallPolicy { smoothness, euclidean };
inline const char* name_of(HallPolicy policy) {
  return policy == HallPolicy::smoothness ? "smooth surfaces" : "near things";
}

/// A segment that spoke: its newest version, and the voxels that it had then, in the hall's frame.
struct SpokenSegment {
  mapping::SegmentDescriptor descriptor;
  mapping::SegmentFeatures features;
  std::vector<rt::Vector3> voxels;
};

/// What became of one visit.
struct HallVisit {
  std::vector<SpokenSegment> segments;
  std::uint64_t silenced{};  ///< versions that were joined or cut, and not described again
  Rounds described_ms;       ///< both visits of the voxels, one a round
  std::uint64_t voxels{};    ///< of all rounds
};

/// Maps scans into a frame that lies in the hall at `map` (hall from map): voxels of 0.1 m, window and
/// segmenter by their defaults, returns up to 25 m, true poses. Once a second all segments are summed up,
/// watched, and those that are wanted described. Of near things returns less than 0.15 m above the floor are
/// left out, as the published method does; else all would hang together.
HallVisit map_visit(const std::vector<HallScan>& scans, const mapping::RigidPose& map, HallPolicy policy);

}  // namespace sortie::bench
