// SPDX-License-Identifier: BSD-3-Clause
#include "rt/convex/query.hpp"

#include "rt/convex/pair.hpp"

namespace sortie::rt::convex {

QueryResult query(const Convex& a, const Convex& b, const Budget& budget) {
  QueryResult result;
  result.normal = {0.0, 0.0, 1.0};
  if (!is_valid(a) || !is_valid(b)) return result;
  const PairJudgement pair = judge_pair(a, b, kTouching_m, 0.0, budget);
  result.state = pair.state;
  result.depth_m = pair.axis.overlap_m;
  result.normal = pair.axis.direction;
  result.support_calls = pair.support_calls;
  if (pair.points.count == 0) return result;
  std::uint32_t deepest = 0;
  for (std::uint32_t i = 1; i < pair.points.count; ++i) {
    if (pair.points.points[i].depth_m > pair.points.points[deepest].depth_m) deepest = i;
  }
  result.point_m = b.p_world_m + pair.points.points[deepest].point_m;
  return result;
}

}  // namespace sortie::rt::convex
