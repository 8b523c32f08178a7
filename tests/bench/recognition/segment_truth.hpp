// SPDX-License-Identifier: BSD-3-Clause
// Which segments of two visits are the same: by their voxels under the true transform.
#pragma once

#include <vector>

#include "tests/bench/recognition/hall_visit.hpp"

namespace sortie::bench {

/// What two segments of two visits are to each other.
enum class SegmentTruth : char {
  different,  ///< of either one, less than a tenth lies where the other one is
  between,    ///< neither: left out
  same,       ///< of either one, half or more lies where the other one is
};

/// Every segment of `first` beside every one of `second`, row by row. A voxel lies where the other segment is
/// if a voxel of that is within 0.2 m of it.
std::vector<SegmentTruth> true_pairs(const std::vector<SpokenSegment>& first,
                                     const std::vector<SpokenSegment>& second);

}  // namespace sortie::bench
