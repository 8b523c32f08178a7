// SPDX-License-Identifier: BSD-3-Clause
// Halls that were visited twice, the pairs of their segments, and how far down a same one stands in a list.
#pragma once

#include <vector>

#include "tests/bench/recognition/roc_curve.hpp"
#include "tests/bench/recognition/segment_likeness.hpp"
#include "tests/bench/recognition/segment_truth.hpp"

namespace sortie::bench {

/// A hall: the segments of its two visits and what they are to each other. Voxels are given up once that is
/// known.
struct HallPairs {
  SecondWay way{};
  HallVisit visit[2];
  HallVisit turned;  ///< of the first visit's scans, in a map that is turned by 45 degrees; may be empty
  std::vector<SegmentTruth> truth;         ///< first visit by second visit
  std::vector<SegmentTruth> turned_truth;  ///< first visit by turned

  SegmentTruth pair(std::size_t first, std::size_t second) const {
    return truth[first * visit[1].segments.size() + second];
  }
};

/// Calls `use(first, second, truth, hall)` for every pair of one hall that is the same or different.
template <class Use>
void for_pairs(const std::vector<HallPairs>& halls, const Use& use) {
  for (std::size_t h = 0; h < halls.size(); ++h) {
    const HallPairs& hall = halls[h];
    for (std::size_t i = 0; i < hall.visit[0].segments.size(); ++i) {
      for (std::size_t k = 0; k < hall.visit[1].segments.size(); ++k) {
        if (hall.pair(i, k) != SegmentTruth::between)
          use(hall.visit[0].segments[i], hall.visit[1].segments[k], hall.pair(i, k), h);
      }
    }
  }
}

/// Where a robot begins its map: anywhere, whatever it heads for. Hall from map.
mapping::RigidPose draw_map(testing::Draws& draws);

/// What is known of the halls, by two policies: index 0 and 1. The same for the same seed.
struct VisitedHalls {
  std::vector<HallPairs> by[2];
};
VisitedHalls visit_halls(int halls, std::uint64_t seed);

/// Of the second visits' segments that are in a store of all first visits' segments of all halls, how many
/// have a same one among the first so many.
struct ListRanks {
  std::size_t targets{};
  std::vector<std::size_t> rank;  ///< of the best same one, one a segment; 0: the first
  double within(std::size_t first) const;
};
ListRanks ranks_by(const std::vector<HallPairs>& halls, const SegmentLikeness& likeness, Likeness by);

}  // namespace sortie::bench
