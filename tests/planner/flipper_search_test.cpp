// SPDX-License-Identifier: BSD-3-Clause
// The search for flipper angles beside the whole grid. Bounds were chosen before seeds 501 on were looked at.
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/planner/flipper_twin.hpp"

namespace sortie::planner {

TEST_CASE("flippers: the search is near the best of the whole grid", "[planner][flippers][heavy]") {
  constexpr std::uint64_t kFirst = 501;
  constexpr int kGrounds = 60;
  const auto search = std::make_unique<FlipperSearch>(posture_vehicle({}), FlipperSearchConfig{});
  std::vector<double> ratio;
  int missed = 0, neither = 0, better = 0;
  double tried = 0.0;
  for (std::uint64_t seed = kFirst; seed < kFirst + kGrounds; ++seed) {
    INFO("seed " << seed);
    DrawnQuestion drawn = drawn_question(seed);
    if (!drawn.stands) continue;
    FlipperFound found;
    REQUIRE(search->search(drawn.ground.view(), drawn.question, found) == Status::ok);
    CHECK(found.units <= search->config().units);
    REQUIRE(found.under.missing == 0);
    tried += found.tried;
    FlipperTwin twin(search->config(), drawn.ground.view(), drawn.question);
    const TwinJudgement own = twin.judge(found.best.angles), best = twin.best_of_grid();
    CHECK(own.safe == (found.best.probability == 0.0));
    CHECK(own.cost == Approx(found.best.cost).margin(1e-6));
    if (!best.safe || !own.safe) {
      ++(best.safe ? missed : neither);
      continue;
    }
    ratio.push_back(own.cost / best.cost);
    if (own.cost < best.cost) ++better;
  }
  std::sort(ratio.begin(), ratio.end());
  REQUIRE(ratio.size() > 20);
  std::printf(
      "search beside the grid: %zu grounds, cost p50 %.3f p90 %.3f worst %.3f of the grid's, %d better (left "
      "and "
      "right apart), %d with a safe choice missed, %d without any; %.1f choices tried\n",
      ratio.size(), ratio[ratio.size() / 2], ratio[ratio.size() * 9 / 10], ratio.back(), better, missed,
      neither, tried / kGrounds);
  CHECK(ratio[ratio.size() / 2] <= 1.02);
  CHECK(ratio[ratio.size() * 9 / 10] <= 1.2);
  CHECK(missed <= kGrounds / 20);
}

}  // namespace sortie::planner
