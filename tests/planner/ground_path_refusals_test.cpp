// SPDX-License-Identifier: BSD-3-Clause
// What the ground planner says of starts, goals, sizes and memory that do not do.
#include <catch2/catch.hpp>
#include <climits>

#include "rt/posix/heap_trap.hpp"
#include "tests/planner/ground_twin.hpp"

namespace sortie::planner::test {
namespace {

using State = GroundPathState;

}  // namespace

TEST_CASE("ground path: what is wrong with start or goal has a name") {
  OwnedGround g(small_ground());
  build_wall(g);
  g.fill(24, 18, 32, 26, GroundState::unknown);
  const auto ask = [&g](GroundPose start, GroundPose goal) { return g.plan(start, goal); };
  CHECK(ask(kWest, kEast) == State::proved);
  CHECK(ask({-1, 8, 0, 0}, kEast) == State::start_outside);
  CHECK(ask({6, 8, 1, 0}, kEast) == State::start_outside);
  CHECK(ask({6, 8, 2, 0}, kEast) == State::start_outside);
  CHECK(ask({6, 8, 0, 16}, kEast) == State::start_outside);
  CHECK(ask({6, 8, 0, kAnyHeading}, kEast) == State::start_outside);
  CHECK(ask({INT_MAX, INT_MIN, 0, 0}, kEast) == State::start_outside);
  CHECK(ask(kWest, {28, 28, 0, 0}) == State::goal_outside);
  CHECK(ask(kWest, {28, 8, -1, 0}) == State::goal_outside);
  CHECK(ask(kWest, {28, 8, 0, -2}) == State::goal_outside);
  CHECK(ask({16, 8, 0, 0}, kEast) == State::start_blocked);
  CHECK(ask({1, 8, 0, 0}, kEast) == State::start_blocked);  // over the map's edge
  CHECK(ask(kWest, {15, 8, 0, kAnyHeading}) == State::goal_blocked);
  CHECK(ask({28, 22, 0, 0}, kEast) == State::start_unknown);
  CHECK(ask(kWest, {28, 22, 0, kAnyHeading}) == State::goal_unknown);
  CHECK(ask(kWest, {6, 8, 0, kAnyHeading}) == State::proved);
  CHECK(g.path.cost() == 0);
  CHECK(g.path.way().size() == 1);
  g.fill(16, 0, 17, 28, GroundState::blocked);
  CHECK(ask(kWest, kEast) == State::none);
  CHECK_FALSE(g.path.has_way());
}

TEST_CASE("ground path: memory that ends says so and keeps the way it had") {
  int kept = 0;
  int full = 0;
  for (const std::size_t columns : {std::size_t{1}, std::size_t{20}, std::size_t{200}, std::size_t{400}}) {
    OwnedGround g(small_ground(), {columns, SIZE_MAX, 1024});
    build_wall(g);
    CHECK(g.plan(kWest, kEast) == State::capacity);
    CHECK(g.path.way().empty() == (g.path.cost() == UINT32_MAX));
  }
  for (std::size_t open = 1; open < 4000; open = open * 5 / 4 + 1) {
    OwnedGround g(small_ground(), {SIZE_MAX, open, 1024});
    build_wall(g);
    const State state = g.plan(kWest, kEast);
    CHECK((state == State::open_full || state == State::proved));
    full += state == State::open_full ? 1 : 0;
    if (state == State::open_full && g.path.has_way()) {
      ++kept;
      CHECK(bad_ground(g, g.path.way()) == 0);
      CHECK(g.path.way().back().pose == kEast);
    }
  }
  CHECK(full > 0);
  CHECK(kept > 0);
  OwnedGround g(small_ground(), {SIZE_MAX, SIZE_MAX, 5});
  build_wall(g);
  OwnedGround longer(small_ground());
  build_wall(longer);
  CHECK(g.plan(kWest, kEast) == State::proved);
  CHECK(longer.plan(kWest, kEast) == State::proved);
  CHECK_FALSE(g.path.is_whole());
  CHECK(g.path.cost() == longer.path.cost());
  REQUIRE(g.path.way().size() == 5);
  CHECK(poses_of(g.path.way()) == poses_of(longer.path.way().first(5)));
  CHECK(g.path.way()[4].cost == longer.path.way()[4].cost);
}

TEST_CASE("ground path: what does not fit is refused, and nothing is read beyond it") {
  const GroundPathConfig good = small_ground();
  OwnedGround g(good);
  CHECK(g.map.set(-1, 0, {}) == Status::out_of_range);
  CHECK(g.map.set(0, 28, {}) == Status::out_of_range);
  CHECK(g.map.set(0, 0, {{0, 0}, {static_cast<GroundState>(3), GroundState::unknown}}) ==
        Status::out_of_range);
  g.map.touch(INT_MIN, INT_MAX);
  CHECK(g.path.run(g.map, 1000) == State::idle);
  const auto refused = [&good](auto change) {
    GroundPathConfig config = good;
    change(config);
    CHECK(check(config) == Status::out_of_range);
    std::vector<std::byte> none;
    rt::Arena arena(none);
    GroundMap map(config, {}, {});
    GroundPath path(config, {}, GroundPathMemory::take(arena, config, 100, 100, 100));
    CHECK(path.begin(map, {}, {}) == State::bad_memory);
    CHECK(path.run(map, UINT64_MAX) == State::bad_memory);
    CHECK_FALSE(map.is_inside(0, 0));
  };
  refused([](GroundPathConfig& c) { c.nx = 0; });
  refused([](GroundPathConfig& c) { c.ny = INT_MAX; });
  refused([](GroundPathConfig& c) { c.cell_mm = 0; });
  refused([](GroundPathConfig& c) { c.speed_mm_s = 0; });
  refused([](GroundPathConfig& c) { c.reverse_mm_s = INT_MIN; });
  refused([](GroundPathConfig& c) { c.turn_mrad_s = -1; });
  refused([](GroundPathConfig& c) { c.half_length_mm = INT_MAX; });
  refused([](GroundPathConfig& c) { c.unknown = static_cast<UnknownGround>(9); });
  refused([](GroundPathConfig& c) { c.unknown_price = 255; });
  refused([](GroundPathConfig& c) { c.posture_margin_cells = -3; });
  // Each part of the memory alone too small, and a map of another size.
  for (int part = 0; part < 7; ++part) {
    GroundPathMemory memory = g.memory;
    if (part == 0) memory.prices = memory.prices.first(memory.prices.size() - 1);
    if (part == 1) memory.distances.nodes = memory.distances.nodes.first(3);
    if (part == 2) memory.columns.columns = {};
    if (part == 3) memory.columns.nodes = memory.columns.nodes.first(15);
    if (part == 4) memory.columns.places = {};
    if (part == 5) memory.heap = {};
    if (part == 6) memory.way = {};
    GroundPath path(good, {}, memory);
    CHECK(path.begin(g.map, kWest, kEast) == State::bad_memory);
  }
  OwnedGround other(small_ground(28, 36));
  CHECK(g.path.begin(other.map, kWest, kEast) == State::bad_memory);
  // Postures of any price, extremes of height.
  std::mt19937 random(5);
  for (auto& price : g.postures) price = static_cast<std::uint8_t>(random() % 256);
  for (std::int32_t y = 0; y < 28; ++y)
    for (std::int32_t x = 0; x < 36; ++x) {
      const auto high = static_cast<std::int16_t>(x % 2 == 0 ? INT16_MIN : INT16_MAX);
      static_cast<void>(g.map.set(x, y, {{high, 0}, {GroundState::carries, GroundState::carries}}));
    }
  const State state = g.plan({6, 8, 1, 0}, {28, 8, 1, kAnyHeading});
  CHECK((state == State::proved || state == State::none || state == State::start_blocked));
}

TEST_CASE("ground path: what is too far to be counted is said") {
  GroundPathConfig config = small_ground();
  config.cell_mm = 1000;
  config.half_length_mm = 1100;
  config.half_width_mm = 700;
  config.speed_mm_s = config.reverse_mm_s = 10;
  OwnedGround g(config);
  g.fill(0, 0, 36, 28, GroundState::carries);
  std::fill(g.postures.begin(), g.postures.end(), kMostPrice);
  CHECK(g.plan(kWest, {28, 20, 0, 4}) == State::proved);
  // Long detours at the greatest price.
  g.fill(9, 0, 10, 22, GroundState::blocked);
  g.fill(16, 6, 17, 28, GroundState::blocked);
  g.fill(23, 0, 24, 22, GroundState::blocked);
  CHECK(g.plan(kWest, kEast) == State::too_far);
  CHECK_FALSE(g.path.has_way());
}

TEST_CASE("ground path: no heap after construction") {
  if (!rt::posix::kHeapTrapAvailable) {
    WARN("skipped: no heap trap under a sanitizer");
    return;
  }
  OwnedGround g(small_ground());
  build_wall(g);
  std::uint64_t calls = 0;
  State state = State::idle;
  CellStep cells[8];
  {
    const rt::posix::HeapTrapScope scope;
    for (int i = 0; i < 3; ++i) {
      g.set(2 + i, 2, GroundState::blocked);
      state = g.plan(kWest, kEast);
      static_cast<void>(g.path.unseen(g.map, cells));
    }
    calls = scope.calls();
  }
  CHECK(state == State::proved);
  CHECK(calls == 0);
}

}  // namespace sortie::planner::test
