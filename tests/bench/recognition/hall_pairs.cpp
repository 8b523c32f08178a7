// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/recognition/hall_pairs.hpp"

#include <algorithm>
#include <cmath>

namespace sortie::bench {
namespace {

void give_up_voxels(HallVisit& visit) {
  for (SpokenSegment& segment : visit.segments) segment.voxels = {};
}

}  // namespace

mapping::RigidPose draw_map(testing::Draws& draws) {
  const rt::Vector3 p{draws.uniform(-3, 3), draws.uniform(-3, 3), draws.uniform(-0.1, 0.1)};
  return {p, rt::from_yaw_pitch_roll(draws.uniform(0, 2 * M_PI), 0, 0)};
}

VisitedHalls visit_halls(int halls, std::uint64_t seed) {
  VisitedHalls visited;
  for (int h = 0; h < halls; ++h) {
    testing::Draws draws(seed + static_cast<std::uint64_t>(h));
    const ThingHall hall = thing_hall(draws);
    std::vector<HallScan> scans[2];
    for (int v = 0; v < 2; ++v) scans[v] = visit_scans(hall, v, hall_lidar(draws), draws);
    const mapping::RigidPose map[2] = {draw_map(draws), draw_map(draws)};
    for (const HallPolicy policy : {HallPolicy::smoothness, HallPolicy::euclidean}) {
      HallPairs pairs;
      pairs.way = hall.second;
      for (int v = 0; v < 2; ++v) pairs.visit[v] = map_visit(scans[v], map[v], policy);
      const std::vector<SpokenSegment>& first = pairs.visit[0].segments;
      pairs.truth = true_pairs(first, pairs.visit[1].segments);
      if (h % 2 == 0) {  // of every other hall, for the sake of time
        const rt::Quaternion turn = rt::from_yaw_pitch_roll(0.25 * M_PI, 0, 0);
        pairs.turned = map_visit(scans[0], {map[0].p, rt::normalised(map[0].q * turn)}, policy);
        pairs.turned_truth = true_pairs(first, pairs.turned.segments);
      }
      for (HallVisit* const visit : {&pairs.visit[0], &pairs.visit[1], &pairs.turned}) give_up_voxels(*visit);
      visited.by[static_cast<int>(policy)].push_back(std::move(pairs));
    }
  }
  return visited;
}

double ListRanks::within(std::size_t first) const {
  const auto found = std::count_if(rank.begin(), rank.end(), [first](std::size_t r) { return r < first; });
  return rank.empty() ? 0.0 : static_cast<double>(found) / static_cast<double>(rank.size());
}

ListRanks ranks_by(const std::vector<HallPairs>& halls, const SegmentLikeness& likeness, Likeness by) {
  ListRanks ranks;
  for (const HallPairs& hall : halls) ranks.targets += hall.visit[0].segments.size();
  for (const HallPairs& own : halls) {
    for (std::size_t k = 0; k < own.visit[1].segments.size(); ++k) {
      const SpokenSegment& segment = own.visit[1].segments[k];
      // Nearest first; of as near ones the one that was put in first, as the store has it.
      std::vector<std::pair<double, std::size_t>> list;
      std::vector<bool> same;
      for (const HallPairs& hall : halls) {
        for (std::size_t i = 0; i < hall.visit[0].segments.size(); ++i) {
          list.emplace_back(likeness.distance(by, segment, hall.visit[0].segments[i]), list.size());
          same.push_back(&hall == &own && own.pair(i, k) == SegmentTruth::same);
        }
      }
      if (std::find(same.begin(), same.end(), true) == same.end()) continue;
      std::sort(list.begin(), list.end());
      std::size_t rank = 0;
      while (!same[list[rank].second]) ++rank;
      // What the gate refuses is in no list.
      ranks.rank.push_back(std::isfinite(list[rank].first) ? rank : list.size());
    }
  }
  return ranks;
}

}  // namespace sortie::bench
