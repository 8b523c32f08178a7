// SPDX-License-Identifier: BSD-3-Clause
// The distance to the goal that leads the ground planner is never too long, so that what it proves is true.
#include <catch2/catch.hpp>

#include "tests/planner/ground_twin.hpp"

TEST_CASE("ground distance: no motion costs less than what it brings nearer, whatever is known and dear",
          "[heavy]") {
  using namespace sortie::planner;
  using namespace sortie::planner::test;
  std::uint64_t motions = 0;
  int reached = 0;
  for (std::uint32_t n = 0; n < 45; ++n) {
    const std::uint32_t seed = 2200 + n;
    CAPTURE(seed, n);
    std::mt19937 random(seed);
    GroundPathConfig config = small_ground();
    config.unknown = static_cast<UnknownGround>(n % 3);
    config.unknown_price = static_cast<std::uint8_t>(random() % 60);
    OwnedGround g(config);
    draw_ground(g, random, n / 3 % kGroundKinds);
    if (n % 2 == 0) {  // single cells block corners that curves pass, and stand out in height
      for (int i = 0; i < 40; ++i) {
        const std::int32_t x = draw_below(random, 36), y = draw_below(random, 28);
        GroundCell cell = g.map.cell(x, y);
        if (cell.state[0] != GroundState::carries) continue;
        if (i % 2 == 0) cell.state[0] = GroundState::blocked;
        cell.height_mm[0] = static_cast<std::int16_t>(cell.height_mm[0] + draw_below(random, 900));
        static_cast<void>(g.map.set(x, y, cell));
      }
    }
    for (auto& price : g.postures) price = std::max(price, static_cast<std::uint8_t>(random() % 8));
    std::vector<std::uint8_t> memory(StandPrices::bytes_for(config));
    StandPrices prices(config, {OwnedGround::price_of, &g, 0, n % 5 == 0 ? nullptr : OwnedGround::least_of},
                       memory);
    std::vector<DistanceNode> nodes(2 * g.cells.size());
    GoalDistance distance(config, g.path.motions(), {nodes});
    const GroundPose goal = draw_pose(g, random, 26, 33);
    const GroundPose start = draw_pose(g, random, 3, 9);
    distance.begin(g.map, goal, start);
    std::uint64_t units = 0;
    while (distance.step(g.map, prices, units)) {
    }
    const auto place = [&g](const GroundPose& p) {
      return static_cast<std::uint32_t>(2 * g.map.index(p.x, p.y)) + static_cast<std::uint32_t>(p.surface);
    };
    GroundTwin twin(g);
    int nearer = 0;
    for (std::int32_t y = 0; y < config.ny; ++y) {
      for (std::int32_t x = 0; x < config.nx; ++x) {
        for (std::int32_t s = 0; s < 2; ++s) {
          for (std::int32_t h = 0; h < kHeadings; ++h) {
            const GroundPose from{x, y, s, h};
            if (twin.stand(from) < 0) continue;
            for (std::uint32_t m = 0; m < kMotions; ++m) {
              GroundPose end;
              const std::int64_t cost = twin.motion_cost(from, g.path.motions().motion(h, m), end);
              if (cost < 0) continue;
              ++motions;
              const std::int64_t gain =
                  std::int64_t{distance.cost(place(from))} - std::int64_t{distance.cost(place(end))};
              nearer += gain > cost ? 1 : 0;
            }
          }
        }
      }
    }
    CHECK(nearer == 0);
    CHECK(distance.cost(place(goal)) == 0);
    if (!distance.is_start_reached()) continue;
    ++reached;
    const double straight_ms =
        1e3 * std::hypot(goal.x - start.x, goal.y - start.y) * config.cell_mm / config.speed_mm_s;
    CHECK(distance.cost(place(start)) >= 0.99 * kCostPerMs * straight_ms);
  }
  CHECK(motions > 100'000);
  CHECK(reached > 10);
}
