// SPDX-License-Identifier: BSD-3-Clause
// Many small maps of the ground, and what every plan over them must keep.
#pragma once

#include <catch2/catch.hpp>

#include "tests/planner/ground_twin.hpp"

namespace sortie::planner::test {

/// Units within which a way must be cheap: about 15 ms. Chosen on seeds from 900,000 on, where 135 ways cost
/// 1.008 of the optimum at the most.
inline constexpr std::uint64_t kGroundBudget = 200'000;

/// How many maps of each answer, and the dearest way at the budget.
struct GroundTally {
  int ways{};
  int walls{};
  int refused{};
  double worst_at_budget{1.0};
};

/// Costs of a way, summed by the twin, which walks it.
inline std::int64_t walked_cost(GroundTwin& twin, const OwnedGround& g, std::span<const GroundStep> way) {
  std::int64_t sum = 0;
  for (std::size_t i = 1; i < way.size(); ++i) {
    GroundPose end;
    const GroundPose& from = way[i - 1].pose;
    const std::int64_t cost =
        twin.motion_cost(from, g.path.motions().motion(from.heading, way[i].motion), end);
    if (cost < 0 || !(end == way[i].pose)) return -1;
    sum += cost;
    if (sum != way[i].cost) return -1;
  }
  return sum;
}

/// The n-th map: there is a way exactly where the twin finds one; within the budget it costs 1.05 of the
/// optimum at most, in the end as much; the robot's outline stays on ground that carries.
inline void judge_ground_map(std::uint32_t seed, std::uint32_t n, GroundTally& tally) {
  CAPTURE(seed, n);
  std::mt19937 random(seed + n);
  GroundPathConfig config = small_ground();
  const std::uint32_t kind = n % kGroundKinds;
  config.unknown = static_cast<UnknownGround>(n / kGroundKinds % 3);
  OwnedGround g(config, {SIZE_MAX, SIZE_MAX, 1024, n / 15 % 2 == 1});
  draw_ground(g, random, kind);
  const GroundPose start = draw_pose(g, random, 3, 9);
  GroundPose goal = draw_pose(g, random, config.nx - 9, config.nx - 3);
  if (n % 2 == 0) goal.heading = kAnyHeading;
  const GroundPathState begun = g.plan(start, goal, 1);
  CHECK(begun == GroundPathState::running);
  const std::uint64_t slice = 1 + 997 * (n % 7);
  std::uint64_t spent = 1;
  while (g.path.work().units < kGroundBudget && spent < kGroundBudget) {
    spent += slice;
    static_cast<void>(g.path.run(g.map, slice));
  }
  const std::uint32_t at_budget = g.path.cost();
  const std::uint32_t bound = g.path.lower_bound();
  const GroundPathState end = g.path.run(g.map, UINT64_MAX);

  GroundTwin twin(g);
  const std::uint64_t optimum = twin.optimum(start, goal);
  CHECK((end == GroundPathState::proved) == (optimum != GroundTwin::kNoWay));
  if (end != GroundPathState::proved) {
    CHECK_FALSE(g.path.has_way());
    (end == GroundPathState::none ? tally.walls : tally.refused) += 1;
    CHECK((end == GroundPathState::none || end == GroundPathState::start_blocked ||
           end == GroundPathState::start_unknown || end == GroundPathState::goal_blocked ||
           end == GroundPathState::goal_unknown));
    return;
  }
  ++tally.ways;
  CHECK(g.path.cost() == optimum);
  CHECK(g.path.lower_bound() == optimum);
  CHECK(bound <= optimum);
  const double ratio = optimum == 0 ? 1.0 : static_cast<double>(at_budget) / static_cast<double>(optimum);
  CHECK(ratio <= 1.05);
  tally.worst_at_budget = std::max(tally.worst_at_budget, ratio);
  const auto way = g.path.way();
  REQUIRE(g.path.is_whole());
  CHECK(way.front().pose == start);
  CHECK(walked_cost(twin, g, way) == static_cast<std::int64_t>(optimum));
  CHECK(bad_ground(g, g.path.drivable()) == 0);
  CHECK((config.unknown != UnknownGround::blocked || g.path.drivable().size() == way.size()));
  if (g.path.drivable().size() < way.size()) {
    CellStep cells[400];
    CHECK(g.path.unseen(g.map, cells) > 0);
  }
}

}  // namespace sortie::planner::test
