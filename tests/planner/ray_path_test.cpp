// SPDX-License-Identifier: BSD-3-Clause
// A ray that was kept goes through the cells of its walk, and is worth the same to the last bit.
#include "planner/ray_path.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "rt/digest.hpp"
#include "tests/planner/ray_small.hpp"

namespace {

using namespace sortie;
using namespace sortie::tests;

// A table that has been covered by rays of a task, with its memory.
struct CoveredTable {
  CoveredTable(const planner::RayScheduler& scheduler, const std::int8_t* cells)
      : lines(400), directory(1u << 12), owners(lines.size()), table({directory, lines, owners}) {
    std::vector<planner::RayModel::Passed> scratch(200);
    planner::RayWorth worth;
    for (std::uint32_t ray = 0; ray < 96; ray += 11)
      good = good && scheduler.model().cover(scheduler.walk(0, ray), cells, table, scratch, worth);
  }
  std::vector<planner::CoverageLine> lines;
  std::vector<std::uint16_t> directory;
  std::vector<std::uint32_t> owners;
  planner::CoverageTable table;
  bool good{true};
};

}  // namespace

TEST_CASE("Rays that are kept have the cells and the worths of their walks") {
  std::uint64_t cells_compared = 0;
  int unlike = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    SmallTask task({12, 8, 20, 5, 1}, seed);
    const planner::RayScheduler& scheduler = task.begin();
    const planner::RayModel& model = scheduler.model();
    const mapping::OccupancyView view = task.map.map.view();
    CoveredTable covered(scheduler, view.cells);
    REQUIRE(covered.good);
    std::vector<std::uint32_t> words(96 * planner::RayPaths::words(200));
    planner::RayPaths paths(words);
    paths.clear(view.size);
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t ray = 0; ray < 96; ++ray) {
      REQUIRE(paths.begin(200));
      const mapping::VoxelWalk walk = scheduler.walk(0, ray);
      const planner::CoverageTable* const table = ray % 2 == 0 ? nullptr : &covered.table;
      const planner::RayWorth noted = model.trace(walk, view.cells, table, &paths);
      numbers.push_back(paths.end(walk));
      unlike += noted.fresh == model.trace(walk, view.cells).fresh ? 0 : 1;
    }
    for (std::uint32_t ray = 0; ray < 96; ++ray) {
      mapping::VoxelWalk walk = scheduler.walk(0, ray);
      const std::uint32_t first = walk.index;
      planner::RayPath path = paths.path(numbers[ray], first);
      const planner::RayWorth now = model.current(path, view.cells, covered.table);
      const planner::RayWorth walked = model.current(walk, view.cells, covered.table);
      unlike += now.current == walked.current && now.cells == walked.cells ? 0 : 1;
      unlike += path.index == walk.index ? 0 : 1;
      for (std::uint32_t i = 1; i < walked.cells; ++i, ++cells_compared) {
        const bool both = walk.step() && path.step();
        unlike += both && path.index == walk.index ? 0 : 1;
      }
    }
  }
  CHECK(unlike == 0);
  CHECK(cells_compared > 20'000);
}

TEST_CASE("A path that may find no room is not begun, and paths before it stay") {
  std::vector<std::uint32_t> words(3);
  planner::RayPaths paths(words);
  const std::int32_t size[3] = {10, 10, 10};
  paths.clear(size);
  mapping::VoxelWalk walk{};
  REQUIRE(paths.begin(20));
  for (int i = 0; i < 19; ++i) paths.put(1);
  const std::uint32_t number = paths.end(walk);
  CHECK_FALSE(paths.begin(20));
  CHECK(paths.begin(15));
  planner::RayPath path = paths.path(number, 7);
  int steps = 0;
  while (path.step()) ++steps;
  CHECK(steps == 19);
  CHECK(path.index == 7 + 19 * 10);
  paths.clear(size);
  CHECK(paths.begin(20));
}

TEST_CASE("What a scheduler kept of the task before says nothing in the next one") {
  int unlike = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const SmallSize size{12, 8, 20, 24, 2};
    planner::RaySchedulerConfig config = SmallTask::scheduler_config(size, seed);
    config.exact = false;
    config.path_words = seed % 2 == 0 ? 0 : 150;  // or they do not find room
    SmallTask used(size, seed + 500, config);
    SmallTask fresh(size, seed, config);
    // Most of the map is sure: few rays are worth anything, and the pattern fills the plans up.
    for (std::size_t i = 0; i < fresh.map.cells.size(); ++i) {
      if (scene_share(i / 50 + seed) < 0.95) fresh.map.cells[i] = -127;
    }
    planner::RayScheduler& again = used.owned.scheduler;
    (void)used.finish();
    REQUIRE(again.begin(fresh.map.map.view(), fresh.poses) == Status::ok);
    (void)fresh.begin();
    while (!again.done()) {
      (void)again.step(5'000);
      (void)fresh.owned.scheduler.step(5'000);
      unlike += rt::digest_of(again.plan()) == rt::digest_of(fresh.owned.scheduler.plan()) ? 0 : 1;
    }
  }
  CHECK(unlike == 0);
}

TEST_CASE("The heap of rays gives back what a sorted set does") {
  std::mt19937_64 random(3);
  std::vector<std::uint64_t> memory(300);
  planner::RayHeap heap(memory);
  std::set<std::uint64_t> sorted;
  int unlike = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t key = random() >> 8 | 1;
    const std::uint64_t what = random() % 8;
    if (what < 3) {
      const bool room = sorted.size() < memory.size();
      unlike += heap.push(key) == room ? 0 : 1;
      if (room) sorted.insert(key);
    } else if (!sorted.empty()) {
      sorted.erase(std::prev(sorted.end()));
      if (what < 6) {
        heap.replace_top(key);
        sorted.insert(key);
      } else {
        heap.pop();
      }
    }
    unlike += heap.size() == sorted.size() ? 0 : 1;
    if (sorted.empty()) continue;
    unlike += heap.top() == *sorted.rbegin() ? 0 : 1;
    unlike += heap.second() == (sorted.size() > 1 ? *std::next(sorted.rbegin()) : 0) ? 0 : 1;
    if (sorted.size() == 150) heap.clear(), sorted.clear();
  }
  CHECK(unlike == 0);
}
