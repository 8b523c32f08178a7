// SPDX-License-Identifier: BSD-3-Clause
// The ray scheduler's state: all that a task leaves to the next one goes to bytes and back.
#include <catch2/catch.hpp>
#include <vector>

#include "rt/archive.hpp"
#include "rt/digest.hpp"
#include "tests/planner/ray_small.hpp"

TEST_CASE("A scheduler that was restored plans the next tasks as the one that was saved, unit by unit") {
  using namespace sortie;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    CAPTURE(seed);
    tests::SmallTask saved({}, seed);
    tests::SmallTask restored({}, seed + 1000, tests::SmallTask::scheduler_config({}, seed));
    (void)restored.finish();  // has another past
    std::mt19937_64 random(seed);
    std::uint32_t passed = planner::RayScheduler::kNothingPassed;
    for (int task = 0; task < 5; ++task) {
      planner::RayScheduler& a = saved.owned.scheduler;
      planner::RayScheduler& b = restored.owned.scheduler;
      rt::Archive measure = rt::Archive::measuring();
      a.archive(measure);
      REQUIRE(measure.status() == Status::ok);
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(measure.bytes()));
      rt::Archive write = rt::Archive::writing(bytes);
      a.archive(write);
      rt::Archive read = rt::Archive::reading(bytes);
      b.archive(read);
      REQUIRE(read.status() == Status::ok);
      REQUIRE(b.done());
      REQUIRE(rt::digest_of(a.plan()) == rt::digest_of(b.plan()));
      REQUIRE(a.begin(saved.map.map.view(), saved.poses, passed) == Status::ok);
      REQUIRE(b.begin(saved.map.map.view(), saved.poses, passed) == Status::ok);
      REQUIRE(rt::digest_of(a.plan()) == rt::digest_of(b.plan()));
      const int slices = static_cast<int>(random() % 30);
      for (int slice = 0; slice < slices; ++slice) {
        (void)a.step(2'000);
        (void)b.step(2'000);
        REQUIRE(rt::digest_of(a.plan()) == rt::digest_of(b.plan()));
      }
      passed = static_cast<std::uint32_t>(random() % 3);
      saved.map.cells[static_cast<std::size_t>(random() % saved.map.cells.size())] = 60;
    }
  }
}
