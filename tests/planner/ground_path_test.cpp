// SPDX-License-Identifier: BSD-3-Clause
// What the ground planner says and does besides finding the cheapest way.
#include <catch2/catch.hpp>
#include <climits>

#include "tests/planner/ground_twin.hpp"

namespace sortie::planner::test {
namespace {

using State = GroundPathState;

}  // namespace

TEST_CASE("ground path: slices of any size give the same ways after as many units") {
  for (std::uint32_t n = 0; n < 25; ++n) {
    const std::uint32_t seed = 81 + n;
    CAPTURE(seed);
    std::mt19937 random(seed);
    OwnedGround whole(small_ground());
    draw_ground(whole, random, n % kGroundKinds);
    const GroundPose start = draw_pose(whole, random, 3, 9);
    const GroundPose goal = draw_pose(whole, random, 27, 33);
    const std::uint64_t total = 1000 + random() % 200'000;
    const State end = whole.plan(start, goal, total);
    for (const std::uint64_t slice : {std::uint64_t{1}, std::uint64_t{37}, std::uint64_t{5000}}) {
      OwnedGround cut(small_ground());
      cut.postures = whole.postures;
      for (std::int32_t y = 0; y < cut.config.ny; ++y)
        for (std::int32_t x = 0; x < cut.config.nx; ++x)
          static_cast<void>(cut.map.set(x, y, whole.map.cell(x, y)));
      // The same tiles as there, or the first phase takes other units.
      cut.changed.assign(cut.changed.size(), ~std::uint64_t{0} >> (64 - 20));
      whole.changed = cut.changed;
      static_cast<void>(whole.plan(start, goal, total));
      static_cast<void>(cut.path.begin(cut.map, start, goal));
      for (std::uint64_t spent = 0; spent < total;) {
        const std::uint64_t now = std::min(slice, total - spent);
        static_cast<void>(cut.path.run(cut.map, now));
        spent += now;
      }
      CHECK(cut.path.state() == whole.path.state());
      CHECK(cut.path.cost() == whole.path.cost());
      CHECK(cut.path.lower_bound() == whole.path.lower_bound());
      CHECK(poses_of(cut.path.way()) == poses_of(whole.path.way()));
    }
    CHECK(end != State::idle);
  }
}

TEST_CASE("ground path: planning again on a map that grew is planning anew", "[heavy]") {
  int changed = 0;
  for (std::uint32_t n = 0; n < 40; ++n) {
    const std::uint32_t seed = 1300 + n;
    CAPTURE(seed);
    std::mt19937 random(seed);
    OwnedGround seen(small_ground());
    draw_ground(seen, random, n % kGroundKinds);
    OwnedGround grown(small_ground());
    const GroundPose start = draw_pose(seen, random, 3, 9);
    // Column by column, from where the robot is, and in the end all; some cells are first seen as something
    // else.
    GroundPose goal;
    for (std::int32_t known = 12; known <= 36; known += 8) {
      for (std::int32_t y = 0; y < 28; ++y) {
        for (std::int32_t x = 0; x < known; ++x) {
          GroundCell cell = seen.map.cell(x, y);
          if (known < 36 && random() % 300 == 0) cell.state[0] = GroundState::blocked;
          static_cast<void>(grown.map.set(x, y, cell));
          for (std::int32_t h = 0; h < kHeadings; ++h) {
            if (grown.posture(x, y, 0, h) == seen.posture(x, y, 0, h) &&
                grown.posture(x, y, 1, h) == seen.posture(x, y, 1, h))
              continue;
            grown.posture(x, y, 0, h) = seen.posture(x, y, 0, h);
            grown.posture(x, y, 1, h) = seen.posture(x, y, 1, h);
            grown.map.touch(x, y);
          }
        }
      }
      CHECK(grown.path.run(grown.map, 1) != State::proved);  // never what was asked on another map
      CHECK_FALSE(grown.path.has_way());
      goal = draw_pose(seen, random, known - 9, known - 4);
      const State state = grown.plan(start, goal, known == 20 ? 5000 : UINT64_MAX);
      changed += state == State::proved && known < 36 ? 1 : 0;
    }
    const State anew = seen.plan(start, goal);
    CHECK(grown.path.state() == anew);
    CHECK(grown.path.cost() == seen.path.cost());
    CHECK(poses_of(grown.path.way()) == poses_of(seen.path.way()));
    // Cell by cell, beside one that has judged nothing yet.
    for (int i = 0; i < 8; ++i) {
      const auto steps = static_cast<std::int32_t>(seen.path.way().size());
      const GroundPose at = steps > 0
                                ? seen.path.way()[static_cast<std::size_t>(draw_below(random, steps))].pose
                                : draw_pose(seen, random, 3, 33);
      const std::int32_t x = at.x + draw_below(random, 7) - 3;
      const std::int32_t y = at.y + draw_below(random, 7) - 3;
      if (!seen.map.is_inside(x, y)) continue;
      GroundCell cell = seen.map.cell(x, y);
      cell.state[0] = cell.state[0] == GroundState::blocked ? GroundState::carries : GroundState::blocked;
      static_cast<void>(seen.map.set(x, y, cell));
      OwnedGround fresh(small_ground());
      fresh.postures = seen.postures;
      for (std::int32_t fy = 0; fy < 28; ++fy)
        for (std::int32_t fx = 0; fx < 36; ++fx)
          static_cast<void>(fresh.map.set(fx, fy, seen.map.cell(fx, fy)));
      CHECK(seen.plan(start, goal) == fresh.plan(start, goal));
      CHECK(poses_of(seen.path.way()) == poses_of(fresh.path.way()));
    }
  }
  CHECK(changed > 10);  // ways on part of the map
}

TEST_CASE("ground path: a way that was proved is not shown any more once a cell on it is blocked") {
  OwnedGround g(small_ground());
  build_wall(g);
  REQUIRE(g.plan(kWest, kEast) == State::proved);
  const GroundPose on_way = g.path.way()[g.path.way().size() / 2].pose;
  g.set(on_way.x, on_way.y, GroundState::blocked);
  CHECK(g.path.run(g.map, 1) == State::outdated);
  CHECK(g.path.drivable().empty());
  CHECK(g.plan(kWest, kEast) == State::proved);
  CHECK(bad_ground(g, g.path.way()) == 0);
}

TEST_CASE("ground path: memory that another map has left says nothing of this one") {
  OwnedGround g(small_ground());
  build_wall(g);
  const GroundMap anew(g.config, g.cells, g.changed);
  for (std::int32_t y = 0; y < anew.ny(); ++y)
    for (std::int32_t x = 0; x < anew.nx(); ++x) REQUIRE(anew.cell(x, y).is_unknown());
}

TEST_CASE("ground path: a map that changed under a plan says so and shows no way") {
  OwnedGround g(small_ground());
  build_wall(g);
  REQUIRE(g.plan(kWest, kEast, 1000) == State::running);
  g.set(3, 3, GroundState::blocked);
  CHECK(g.path.run(g.map, 1000) == State::outdated);
  CHECK_FALSE(g.path.has_way());
  CHECK(g.plan(kWest, kEast) == State::proved);
}

TEST_CASE("ground path: a mirrored map has the mirrored costs") {
  int ways = 0;
  for (std::uint32_t n = 0; n < 40; ++n) {
    const std::uint32_t seed = 7000 + n;
    CAPTURE(seed);
    std::mt19937 random(seed);
    OwnedGround g(small_ground());
    draw_ground(g, random, n % kGroundKinds);
    OwnedGround mirrored(small_ground());
    const auto mirror = [](GroundPose p) {
      p.y = 27 - p.y;
      if (p.heading != kAnyHeading) p.heading = wrap_heading(-p.heading);
      return p;
    };
    for (std::int32_t y = 0; y < 28; ++y) {
      for (std::int32_t x = 0; x < 36; ++x) {
        static_cast<void>(mirrored.map.set(x, 27 - y, g.map.cell(x, y)));
        for (std::int32_t h = 0; h < kHeadings; ++h)
          for (std::int32_t s = 0; s < 2; ++s)
            mirrored.posture(x, 27 - y, s, wrap_heading(-h)) = g.posture(x, y, s, h);
      }
    }
    const GroundPose start = draw_pose(g, random, 3, 9);
    const GroundPose goal = draw_pose(g, random, 27, 33);
    const State state = g.plan(start, goal);
    CHECK(mirrored.plan(mirror(start), mirror(goal)) == state);
    CHECK(mirrored.path.cost() == g.path.cost());
    ways += state == State::proved ? 1 : 0;
  }
  CHECK(ways > 10);
}

TEST_CASE("ground path: nothing drives off a mezzanine, for the way down is the ramp") {
  OwnedGround g(small_ground());
  g.fill(0, 0, 36, 28, GroundState::carries);
  for (std::int32_t y = 0; y < 28; ++y) {
    for (std::int32_t x = 18; x < 36; ++x)
      static_cast<void>(g.map.set(x, y, {{0, 1400}, {GroundState::carries, GroundState::carries}}));
  }
  const GroundPose above{28, 8, 1, 8};
  const GroundPose below{28, 8, 0, kAnyHeading};
  CHECK(g.plan(above, below) == State::none);
  for (const UnknownGround unknown : {UnknownGround::by_price, UnknownGround::look_first}) {
    GroundPathConfig hopes = small_ground();
    hopes.unknown = unknown;
    OwnedGround hoping(hopes);
    for (std::int32_t y = 0; y < 28; ++y)
      for (std::int32_t x = 0; x < 36; ++x) static_cast<void>(hoping.map.set(x, y, g.map.cell(x, y)));
    CHECK(hoping.plan(above, below) == State::none);
    // Beside the edge nothing was seen: hoped for, not driven.
    hoping.fill(10, 0, 18, 28, GroundState::unknown);
    CHECK(hoping.plan(above, below) == State::proved);
    CHECK(hoping.path.drivable().size() < hoping.path.way().size());
    CHECK(bad_ground(hoping, hoping.path.drivable()) == 0);
    for (const GroundStep& step : hoping.path.drivable()) CHECK(step.pose.x >= 18);
  }
  for (std::int32_t x = 8; x < 18; ++x) g.fill(x, 16, x + 1, 24, GroundState::carries, 140 * (x - 7));
  CHECK(g.plan(above, below) == State::proved);
  bool on_ramp = false;
  for (const GroundStep& step : g.path.way())
    on_ramp = on_ramp || (step.pose.x < 18 && step.pose.y >= 16 && step.pose.y < 24);
  CHECK(on_ramp);
}

TEST_CASE("ground path: unknown ground is gone around, hoped for at its price, or looked at first") {
  const auto plan = [](UnknownGround unknown, std::int32_t look_ms, auto judge) {
    GroundPathConfig config = small_ground();
    config.unknown = unknown;
    config.look_ms = look_ms;
    config.unknown_price = 4;
    OwnedGround g(config);
    g.fill(0, 0, 36, 28, GroundState::carries);
    g.fill(15, 0, 18, 21, GroundState::unknown);
    CHECK(g.plan(kWest, kEast) == State::proved);
    judge(g);
    return g.path.cost();
  };
  const std::uint32_t around = plan(UnknownGround::blocked, 0, [](OwnedGround& g) {
    CHECK(g.path.drivable().size() == g.path.way().size());
    CellStep cells[4];
    CHECK(g.path.unseen(g.map, cells) == 0);
  });
  const std::uint32_t hoped = plan(UnknownGround::by_price, 0, [](OwnedGround& g) {
    CHECK(g.path.drivable().size() < g.path.way().size());
    CHECK(g.path.drivable().size() > 3);
    CellStep cells[64];
    const std::size_t count = g.path.unseen(g.map, cells);
    REQUIRE(count > 0);
    for (std::size_t i = 0; i < count; ++i) CHECK((cells[i].x >= 15 && cells[i].x < 18));
    CHECK(g.path.unseen(g.map, std::span(cells).first(1)) == 1);
  });
  const std::uint32_t looked = plan(UnknownGround::look_first, 500, [](OwnedGround& g) {
    CHECK(g.path.drivable().size() < g.path.way().size());
  });
  const std::uint32_t too_long = plan(UnknownGround::look_first, 60'000, [](OwnedGround& g) {
    CHECK(g.path.drivable().size() == g.path.way().size());
  });
  CHECK(hoped < around);
  CHECK(looked == hoped + 500 * kCostPerMs);
  CHECK(too_long == around);
}

}  // namespace sortie::planner::test
