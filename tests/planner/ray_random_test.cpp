// SPDX-License-Identifier: BSD-3-Clause
// Some thousand random tasks beside literal greedy, and the two that were found first.
#include <catch2/catch.hpp>

#include "tests/planner/ray_random.hpp"

namespace {

using namespace sortie;
using namespace sortie::tests;

}  // namespace

TEST_CASE("Random rays: plans, budgets and certificates beside literal greedy", "[heavy]") {
  constexpr std::uint64_t kFirst = 1;
  constexpr std::uint64_t kLast = 3001;
  const RandomTally tally = judge_random_rays(kFirst, kLast);
  CAPTURE(kFirst, kLast, tally.dearest);
  CHECK(tally.faults == std::vector<std::string>{});
  // Or a kind of task was never there.
  CHECK(tally.exact > 150);
  CHECK(tally.full > 300);
  CHECK(tally.full_certified > 100);
  CHECK(tally.tried_all > 100);
  CHECK(tally.all_taken > 100);
  CHECK(tally.worthless > 30);
  CHECK(tally.single > 500);
  CHECK(tally.dearest > 0.9);
}

TEST_CASE("Rays: a small sensor keeps its budget") {
  SmallTask task({12, 8, 20, 10, 1}, 7);
  planner::RaySchedulerConfig config = task.owned.scheduler.config();
  config.sensor.range_m = 1.0;
  for (const std::uint32_t lines : {0u, 1u, 64u}) {
    config.table_lines = lines;
    SmallTask small({12, 8, 20, 10, 1}, 7, config);
    planner::RayScheduler& scheduler = small.begin();
    CHECK(scheduler.step(700) <= 700);
    CHECK(scheduler.plan().units <= 700);
    // Nothing wraps where all units there are follow a rest.
    (void)scheduler.step(UINT64_MAX);
    CHECK(scheduler.done());
  }
}

// What is known at a cell's corner, as part of the seed, goes into the heap with its three new directions.
// Rays go along the diagonal of the window, as long as they can be, and their paths are not kept.
TEST_CASE("Rays: no step is dearer than the dearest where a cell is refined whose corner is known",
          "[heavy]") {
  mapping::OccupancyConfig cube;
  for (std::int32_t& size : cube.size) size = 20;
  RayMap map(cube);
  for (std::int8_t& cell : map.cells) cell = -20;
  const mapping::OccupancyView view = map.map.view();
  mapping::SensorPose pose;
  pose.p_world_sensor_m =
      view.voxel_size_m * rt::Vector3{view.low[0] + 0.999, view.low[1] + 0.999, view.low[2] + 0.999};
  pose.q_world_sensor =
      rt::exp_rotation({0, 0, 0.7853981633974483}) * rt::exp_rotation({0, -0.6154797086703873, 0});
  double dearest = 0;
  for (std::uint32_t columns = 4; columns < 16; ++columns) {
    for (std::uint32_t rays = 8; rays < 8 * columns; rays += 3) {
      planner::RaySchedulerConfig config;
      config.sensor = {columns, 8, 1e-6, 1e-6, 3.0};
      config.rays = rays;
      config.positions = 1;
      config.map_cells = 8000;
      config.path_words = 1;
      config.optimism = 1.5;  // cells come before their corners
      OwnedScheduler owned(config);
      REQUIRE(owned.scheduler.begin(view, {&pose, 1}) == Status::ok);
      while (!owned.scheduler.done()) {
        const auto cost = static_cast<double>(owned.scheduler.step(1));
        dearest = std::max(dearest, cost / static_cast<double>(owned.scheduler.largest_step()));
      }
    }
  }
  CAPTURE(dearest);
  CHECK(dearest <= 1);
  CHECK(dearest > 0.95);  // or no step came near
}
