// SPDX-License-Identifier: BSD-3-Clause
// The ray scheduler at every moment: valid plans, budgets kept, slices, rising worth, seeds, hard maps.
#include <catch2/catch.hpp>

#include "rt/posix/heap_trap.hpp"
#include "tests/planner/ray_hard.hpp"

namespace {
using namespace sortie;
using namespace sortie::tests;
}  // namespace

TEST_CASE("Rays on hard maps: plans are valid, budgets are kept, and more units never give less") {
  const HardResult result = sweep_hard_maps(small_hard_task(), 12);
  CHECK(result.invalid == 0);
  CHECK(result.beyond == 0);
  CHECK(result.falls == 0);
  CHECK(result.rises > 20);  // or nothing was planned
}

TEST_CASE("Rays: the plan does not depend on how units were sliced") {
  const HardTask task = small_hard_task();
  for (std::size_t number = 0; number < hard_maps().size(); number += 3) {
    RayMap map(task.map);
    make_hard_map(map, number);
    const auto poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
    OwnedScheduler whole(task.config);
    OwnedScheduler sliced(task.config);
    REQUIRE(whole.scheduler.begin(map.map.view(), poses) == Status::ok);
    REQUIRE(sliced.scheduler.begin(map.map.view(), poses) == Status::ok);
    std::mt19937_64 random(number);
    std::uint64_t given = 0;
    for (int i = 0; i < 200; ++i) {
      const std::uint64_t units = random() % 3000;
      given += units;
      (void)sliced.scheduler.step(units);
    }
    (void)whole.scheduler.step(given);
    CHECK(rt::digest_of(whole.scheduler.plan()) == rt::digest_of(sliced.scheduler.plan()));
    CHECK(chosen_rows(whole.scheduler) == chosen_rows(sliced.scheduler));
    CHECK(sliced.scheduler.plan().units <= given);
    const bool used_up = given - sliced.scheduler.plan().units < sliced.scheduler.largest_step();
    CHECK((used_up || sliced.scheduler.done()));
  }
}

TEST_CASE("Rays: no ray, more rays than directions, and no unit to spend") {
  HardTask task = small_hard_task();
  RayMap map(task.map);
  make_hard_map(map, 7);
  const auto poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
  for (const std::uint32_t k : {0u, 1u, 47u, 48u, 1000u}) {
    task.config.sensor.columns = 8;
    task.config.sensor.rows = 6;
    task.config.rays = k;
    OwnedScheduler owned(task.config);
    REQUIRE(owned.scheduler.begin(map.map.view(), poses) == Status::ok);
    CHECK(is_valid_plan(owned.scheduler));
    (void)owned.scheduler.step(0);
    CHECK(is_valid_plan(owned.scheduler));
    (void)owned.scheduler.step(100'000'000);
    CHECK(owned.scheduler.done());
    CHECK(is_valid_plan(owned.scheduler));
    const RayMatrix matrix = build_ray_matrix(owned.scheduler, map.map.view());
    CHECK(owned.scheduler.plan().worth == Approx(matrix.worth(chosen_rows(owned.scheduler))).epsilon(0.01));
    if (k == 0 || k >= 48) CHECK(owned.scheduler.plan().certificate == Approx(1.0).epsilon(1e-6));
  }
}

TEST_CASE("Rays: the plan before is moved on, and is where the next one starts from") {
  const HardTask task = small_hard_task();
  RayMap map(task.map);
  make_hard_map(map, 7);
  const auto poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
  OwnedScheduler owned(task.config);
  REQUIRE(owned.scheduler.begin(map.map.view(), poses) == Status::ok);
  (void)owned.scheduler.step(100'000'000);
  const std::vector<std::uint16_t> second(owned.scheduler.rays(1).begin(), owned.scheduler.rays(1).end());
  REQUIRE(owned.scheduler.begin(map.map.view(), poses, 1) == Status::ok);
  const std::vector<std::uint16_t> first(owned.scheduler.rays(0).begin(), owned.scheduler.rays(0).end());
  CHECK(first == second);
  CHECK(is_valid_plan(owned.scheduler));
  // From a plan that was thought through, first stages would lead to worse ones: they are not taken.
  REQUIRE(owned.scheduler.begin(map.map.view(), poses) == Status::ok);
  (void)owned.scheduler.step(100'000'000);
  REQUIRE(owned.scheduler.begin(map.map.view(), poses, 0) == Status::ok);
  std::vector<double> left(static_cast<std::size_t>(map.map.view().cell_count()));
  const double before = cut_worth(owned.scheduler, map.map.view(), left);
  while (!owned.scheduler.done()) {
    (void)owned.scheduler.step(2000);
    REQUIRE(cut_worth(owned.scheduler, map.map.view(), left) >= before * (1 - 1e-9));
  }
  // A plan that was moved on by more than its length is the pattern.
  REQUIRE(owned.scheduler.begin(map.map.view(), poses, 99) == Status::ok);
  OwnedScheduler fresh(task.config);
  REQUIRE(fresh.scheduler.begin(map.map.view(), poses) == Status::ok);
  CHECK(chosen_rows(owned.scheduler) == chosen_rows(fresh.scheduler));
}

// A joint plan, and a first position that is chosen anew for itself: what it covers, the others cover
// already.
TEST_CASE("Rays: a seed is kept where a new first position is worth less beside the rest") {
  const HardTask task = small_hard_task();
  std::uint64_t kept = 0;
  for (std::size_t number = 0; number < hard_maps().size(); ++number) {
    RayMap map(task.map);
    make_hard_map(map, number);
    const mapping::OccupancyView view = map.map.view();
    const auto poses = poses_ahead(view, task.config.positions, 0.2);
    std::vector<double> left(static_cast<std::size_t>(view.cell_count()));
    OwnedScheduler whole(task.config);
    REQUIRE(whole.scheduler.begin(view, poses) == Status::ok);
    (void)whole.scheduler.step(100'000'000);
    const double before = cut_worth(whole.scheduler, view, left);
    const std::uint64_t digest = whole.scheduler.plan().digest;
    for (std::uint64_t budget = 10'000; budget < 500'000; budget = budget * 3 / 2) {
      REQUIRE(whole.scheduler.begin(view, poses, 0) == Status::ok);
      (void)whole.scheduler.step(budget);
      CHECK(cut_worth(whole.scheduler, view, left) >= before * (1 - 1e-9));
      kept += whole.scheduler.plan().digest == digest ? 1 : 0;
      REQUIRE(whole.scheduler.begin(view, poses, 0) == Status::ok);
      (void)whole.scheduler.step(100'000'000);
    }
  }
  CHECK(kept > 20);
}

TEST_CASE("Rays: a full table ends growth, drops nothing, and keeps plans valid and rising") {
  HardTask task = small_hard_task();
  task.config.table_lines = 40;
  const HardResult result = sweep_hard_maps(task, 8);
  CHECK(result.invalid == 0);
  CHECK(result.beyond == 0);
  CHECK(result.falls == 0);
  CHECK(result.full > 0);
}

TEST_CASE("Rays: bad tasks are refused, poses outside the map are worth nothing") {
  const HardTask task = small_hard_task();
  RayMap map(task.map);
  make_hard_map(map, 7);
  OwnedScheduler owned(task.config);
  std::vector<mapping::SensorPose> poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
  CHECK(owned.scheduler.begin({}, poses) == Status::out_of_range);
  CHECK(owned.scheduler.begin(map.map.view(), {}) == Status::out_of_range);
  poses[0].p_world_sensor_m.x = std::nan("");
  CHECK(owned.scheduler.begin(map.map.view(), poses) == Status::not_finite);
  poses[0].p_world_sensor_m.x = 1e12;
  poses[1].p_world_sensor_m.x = -1e300;
  CHECK(owned.scheduler.begin(map.map.view(), poses) == Status::ok);
  (void)owned.scheduler.step(100'000'000);
  CHECK(is_valid_plan(owned.scheduler));
  CHECK(owned.scheduler.done());
  planner::RaySchedulerConfig bad = task.config;
  bad.positions = 17;
  CHECK(planner::RayScheduler::memory_bytes(bad) == 0);
  CHECK_FALSE(OwnedScheduler(bad).scheduler.usable());
  std::vector<std::byte> little(100);
  CHECK_FALSE(planner::RayScheduler(task.config, little).usable());
}

TEST_CASE("Rays: memory at the paper's setting") {
  planner::RaySchedulerConfig config;
  CHECK(planner::RayScheduler::memory_bytes(config) <= 6u << 20);
  config.positions = 1;
  CHECK(planner::RayScheduler::memory_bytes(config) <= 3u << 19);
}

TEST_CASE("Rays: no heap call after construction") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  const HardTask task = small_hard_task();
  RayMap map(task.map);
  make_hard_map(map, 7);
  const auto poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
  OwnedScheduler owned(task.config);
  std::uint64_t calls = 0;
  bool good = true;
  {
    const rt::posix::HeapTrapScope scope;
    for (std::uint32_t i = 0; i < 3; ++i) {
      good = good && map.map.centre_on({5.0 * i, 0, 0}) == Status::ok;
      good = good && map.map.update_ray({5.0 * i, 0, 0}, {5.0 * i + 3, 1, 0}, true) == Status::ok;
      good = good && owned.scheduler.begin(map.map.view(), poses, i) == Status::ok;
      (void)owned.scheduler.step(2'000'000);
    }
    calls = scope.calls();
  }
  CHECK(calls == 0);
  CHECK(good);
}

TEST_CASE("Rays: the same plan with every compiler and on every processor") {
  const HardTask task = small_hard_task();
  std::uint64_t digest = 0;
  for (std::size_t number = 0; number < hard_maps().size(); number += 2) {
    RayMap map(task.map);
    make_hard_map(map, number);
    std::vector<mapping::SensorPose> poses = poses_ahead(map.map.view(), task.config.positions, 1.0);
    for (mapping::SensorPose& pose : poses) pose.q_world_sensor = rt::exp_rotation({0.02, -0.03, 0.4});
    OwnedScheduler owned(task.config);
    REQUIRE(owned.scheduler.begin(map.map.view(), poses) == Status::ok);
    for (int i = 0; i < 3; ++i) {
      (void)owned.scheduler.step(60'000);
      digest = rt::chain_digest(digest, number, rt::digest_of(owned.scheduler.plan()));
    }
  }
  CHECK(digest == 0x08acbbab35c69321ull);
}
