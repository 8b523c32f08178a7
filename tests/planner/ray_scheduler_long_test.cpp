// SPDX-License-Identifier: BSD-3-Clause
// The ray scheduler at the paper's full setting, and on many small tasks.
#include <catch2/catch.hpp>

#include "tests/planner/ray_hard.hpp"
#include "tests/planner/ray_proofs.hpp"
#include "tests/planner/ray_random.hpp"

namespace {
using namespace sortie;
using namespace sortie::tests;

std::vector<mapping::SensorPose> street_poses(const RayMap& map, std::uint64_t seed,
                                              std::uint32_t positions) {
  const Street street(map.map.config().size, seed);
  std::vector<mapping::SensorPose> poses;
  for (std::uint32_t p = 0; p < positions; ++p) poses.push_back(street_pose(street, map.map.view(), 4.0 * p));
  return poses;
}
}  // namespace

TEST_CASE("Full rays: the exact stage chooses what plain greedy chooses on streets", "[long]") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    planner::RaySchedulerConfig config;
    config.positions = seed == 3 ? 2 : 1;
    config.position_first = false;
    config.joint = false;
    RayMap map;
    make_street(map, seed, config.sensor, seed != 2);
    OwnedScheduler owned(config);
    REQUIRE(owned.scheduler.begin(map.map.view(), street_poses(map, seed, config.positions)) == Status::ok);
    while (!owned.scheduler.done()) (void)owned.scheduler.step(1'000'000);
    const auto naive = naive_on_the_model(owned.scheduler, map.map.view());
    CHECK(naive.size() == 200 * config.positions);
    CHECK(owned.scheduler.plan().stage == planner::RayStage::exact);
    CHECK(begins_with(owned.scheduler, naive));
    CHECK(owned.scheduler.plan().certificate > 0.5);
  }
}

TEST_CASE("Full rays: rising budgets on nine hard maps", "[long]") {
  HardTask task;
  const HardResult result = sweep_hard_maps(task, 24);
  CHECK(result.invalid == 0);
  CHECK(result.beyond == 0);
  CHECK(result.falls == 0);
  task = small_hard_task();
  const HardResult small = sweep_hard_maps(task, 64);
  CHECK(small.invalid == 0);
  CHECK(small.beyond == 0);
  CHECK(small.falls == 0);
}

TEST_CASE("The exact stage chooses what plain greedy chooses on ten thousand tasks", "[long]") {
  CHECK(lazy_unlike_naive(1, 10001) == std::vector<std::uint64_t>{});
}

TEST_CASE("Ray plans keep their bounds on three thousand tasks", "[long]") {
  const BoundResult result = check_bounds(1, 3001);
  CHECK(result.broken == 0);
  check_bounds_hold(result);
}

TEST_CASE("Random rays: a hundred thousand tasks beside literal greedy", "[long]") {
  constexpr std::uint64_t kFirst = 100'000;
  constexpr std::uint64_t kLast = 200'000;
  const RandomTally tally = judge_random_rays(kFirst, kLast);
  CAPTURE(kFirst, kLast, tally.dearest);
  CHECK(tally.faults == std::vector<std::string>{});
  CHECK(tally.full_certified > 3000);
}
