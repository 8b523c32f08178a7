// SPDX-License-Identifier: BSD-3-Clause
// What the elevation map says of steps, walls, floors over floors, holes and what nobody saw.
// Heights here are known, so that no twin is needed.
#include <catch2/catch.hpp>
#include <limits>

#include "tests/mapping/elevation_looker.hpp"
#include "tests/mapping/world_random.hpp"

namespace {

using namespace sortie;
using namespace sortie::mapping;
using tests::Looker;
using tests::patch;
using tests::window_64;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("elevation: a step through a cell keeps both of its surfaces") {
  Looker looker;
  // The edge lies in the middle of the cell 1.00 .. 1.05.
  for (int scan = 0; scan < 20; ++scan) {
    looker.look({0, 0, 0.6}, patch(0.5, 1.025, -0.2, 0.2, 0.0));
    looker.look({0, 0, 0.6}, patch(1.025, 1.5, -0.2, 0.2, 0.2));
  }
  const GroundSpan edge = looker.ground(1.03, 0.01);
  CHECK(edge.state == GroundState::measured);
  CHECK(edge.low_m == Approx(0.0).margin(1e-5));
  CHECK(edge.high_m == Approx(0.2).margin(1e-5));
  for (const double x : {0.7, 0.96}) CHECK(looker.ground(x, 0.01).high_m == Approx(0.0).margin(1e-5));
  for (const double x : {1.08, 1.4}) CHECK(looker.ground(x, 0.01).low_m == Approx(0.2).margin(1e-5));
  CHECK(edge.sigma_m < 0.005);
}

TEST_CASE("elevation: a wall is an edge from its foot to where it was seen, whatever came between") {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    tests::WorldRandom random(seed);
    Looker looker;
    std::vector<rt::Vector3> wall{{1.01, 0.01, 0.0}, {1.01, 0.01, 0.0}, {1.01, 0.01, 0.5}, {1.01, 0.01, 0.5}};
    for (int i = 0; i < 500; ++i) wall.push_back({1.01, 0.01, random.between(0.0, 0.5)});
    looker.look({0, 0, 0.6}, wall);
    const GroundSpan span = looker.ground(1.01, 0.01);
    // A surface is the mean of what joined it: from not farther than three deviations of two returns, about
    // 1.3 m away, and half a join more where two became one.
    const ElevationConfig& c = looker.owned.map.config();
    const double gate_m = 3 * std::sqrt(2.0) * std::hypot(c.noise_m, 1.3 * c.noise_per_m) + 0.5 * c.join_m;
    CHECK(span.low_m < gate_m);
    CHECK(span.high_m > 0.5 - gate_m);
    CHECK(span.low_m >= -1e-5);
    CHECK(span.high_m <= 0.5 + 1e-5);
  }
}

TEST_CASE("elevation: a wall higher than a doorway is never a floor with a ceiling") {
  for (const double sensor_m : {0.5, 1.5, 2.5}) {
    for (std::uint32_t seed = 1; seed <= 200; ++seed) {
      CAPTURE(sensor_m, seed);
      tests::WorldRandom random(seed);
      Looker looker;
      std::vector<rt::Vector3> wall;
      for (int i = 0; i < 500; ++i) wall.push_back({1.01, 0.01, random.between(0.0, 3.0)});
      looker.look({0, 0, sensor_m}, wall);
      const GroundSpan span = looker.ground(1.01, 0.01);
      // The lowest surface may have risen above what the asker climbs: then the ground is not known.
      CAPTURE(span.low_m, span.high_m);
      CHECK((span.state == GroundState::measured ? span.high_m > 2.5 : span.has_ceiling));
    }
  }
}

TEST_CASE("elevation: a floor over a floor is another level, and each asker gets his own") {
  Looker looker;
  looker.look({0, 0, 0.6}, patch(0.5, 1.5, -0.2, 0.2, 0.0));
  looker.look({0, 0, 0.6}, patch(0.5, 1.5, -0.2, 0.2, 2.0));  // its underside
  const GroundSpan below = looker.ground(1, 0);
  CHECK(below.high_m == Approx(0.0).margin(1e-5));
  CHECK(below.has_ceiling);
  CHECK(below.ceiling_m == Approx(2.0).margin(1e-5));
  // Nobody has seen its top yet: what is known there was seen from below.
  CHECK(looker.ground(1, 0, 2.2).from_below);
  looker.look({0, 0, 2.8}, patch(0.5, 1.5, -0.2, 0.2, 2.2));
  const GroundSpan above = looker.ground(1, 0, 2.2);
  CHECK_FALSE(above.from_below);
  CHECK_FALSE(above.has_ceiling);
  CHECK(above.low_m == Approx(2.2).margin(1e-5));  // not the underside
  CHECK(above.high_m == Approx(2.2).margin(1e-5));
  CHECK(looker.ground(1, 0).high_m == Approx(0.0).margin(1e-5));
  CHECK(looker.ground(1, 0).ceiling_m == Approx(2.0).margin(1e-5));
}

TEST_CASE("elevation: a ramp that is higher than the sensor is ground although it was seen from below") {
  Looker looker;
  std::vector<rt::Vector3> ramp;
  for (double x = 1.0; x < 3.0; x += 0.01) ramp.push_back({x, 0.01, 0.6 * (x - 1.0)});
  looker.look({0, 0, 0.5}, ramp);
  for (const double x : {1.52, 2.52}) {
    const GroundSpan span = looker.ground(x, 0.01, 0.6 * (x - 1));
    CHECK(span.state == GroundState::measured);
    CHECK(span.low_m == Approx(0.6 * (x - 1)).margin(0.02));
    CHECK(span.from_below == (x > 2));
  }
}

TEST_CASE("elevation: a hole that rays passed over is not the same as what nobody saw") {
  // A floor that ends at x = 1, a pit, and its far wall at x = 2 that rays reach 0.8 m under the floor.
  Looker looker;
  looker.look({0, 0, 0.6}, patch(0.3, 1.0, -0.2, 0.2, 0.0));
  std::vector<rt::Vector3> wall;
  for (double z = -0.55; z < -0.1; z += 0.01)
    for (double y = -0.15; y <= 0.151; y += 0.01) wall.push_back({2.01, y, z});
  looker.look({0, 0, 0.6}, wall);
  const GroundSpan hole = looker.ground(1.5, 0.01);
  CHECK(hole.state == GroundState::bounded);
  // The lowest ray that passes the edge at (1, 0) is at -0.3 half-way over the pit.
  CHECK(hole.bound_m < -0.2);
  CHECK(hole.bound_m > -0.32);
  const GroundSpan unseen = looker.ground(1.5, 1.5);
  CHECK(unseen.state == GroundState::unknown);
  CHECK_FALSE(unseen.has_bound);
  CHECK(looker.ground(0.7, 0.01).state == GroundState::measured);
  CHECK(looker.ground(900, 900).state == GroundState::unknown);
  // From two metres higher up this bound says nothing: a floor may lie between.
  CHECK(looker.ground(1.5, 0.01, 2.0).state == GroundState::unknown);
}

TEST_CASE("elevation: a bound of the floor below gives way to one of the floor that the robot is on") {
  Looker looker;
  looker.look({0, 0, 0.6}, {{2.0, 0.01, 0.0}});  // passes x = 1.5 at 0.15 m
  CHECK(looker.ground(1.52, 0.01).bound_m < 0.2);
  looker.look({0, 0, 2.8}, {{2.0, 0.01, 2.2}});
  CHECK(looker.ground(1.52, 0.01, 2.2).state == GroundState::bounded);
  CHECK(looker.ground(1.52, 0.01, 2.2).bound_m == Approx(2.35).margin(0.02));
}

TEST_CASE("elevation: standing still for a minute changes no cell that is not seen") {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    tests::WorldRandom random(seed);
    Looker looker(window_64());
    looker.look({0, 0, 0.6}, patch(-1.5, 1.5, -1.5, 1.5, 0.1));
    const ElevationView view = looker.owned.map.view();
    const std::vector<ElevationCell> before(view.cells, view.cells + view.size * view.size);
    const std::vector<std::int32_t> bounds(view.bounds, view.bounds + view.size * view.size);
    // 600 scans of the right half only, with noise.
    for (int scan = 0; scan < 600; ++scan) {
      REQUIRE(looker.owned.map.centre_on({0, 0, 0}) == Status::ok);
      std::vector<rt::Vector3> seen;
      for (int i = 0; i < 100; ++i)
        seen.push_back({random.between(-1.5, 1.5), random.between(-1.5, -0.1), 0.1 + 0.01 * random.normal()});
      looker.look({0, 0, 0.6}, seen);
    }
    std::size_t moved = 0;
    for (std::int64_t y = view.low[1]; y < view.low[1] + view.size; ++y) {
      for (std::int64_t x = view.low[0]; x < view.low[0] + view.size; ++x) {
        const std::uint32_t at = view.index(x, y);
        const bool same = std::memcmp(&before[at], &view.cells[at], sizeof(ElevationCell)) == 0 &&
                          bounds[at] == view.bounds[at];
        if (y >= 0) REQUIRE(same);
        if (!same) ++moved;
      }
    }
    CHECK(moved > 500);
  }
}

TEST_CASE("elevation: what the tracks felt is known to a centimetre, without any scan") {
  Looker looker;
  CHECK(looker.ground(0.2, 0.2).state == GroundState::unknown);
  REQUIRE(looker.owned.map.feel(std::vector<rt::Vector3>{{0.21, 0.21, 0.07}}) == Status::ok);
  const GroundSpan span = looker.ground(0.21, 0.21);
  CHECK(span.state == GroundState::felt);
  CHECK(span.high_m == Approx(0.07).margin(1e-5));
  CHECK(span.sigma_m == Approx(0.01).margin(1e-4));
  CHECK(looker.owned.map.feel(std::vector<rt::Vector3>{{kNaN, 0, 0}}) == Status::not_finite);
  CHECK(looker.owned.map.feel(std::vector<rt::Vector3>{{90, 0, 0}}) == Status::out_of_range);
  CHECK(looker.owned.map.output().lost == 1);
}

TEST_CASE("elevation: a pose that jumps leaves no double step once its variance was said") {
  const auto heights = [](double said_m2) {
    Looker looker;
    for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
    REQUIRE(looker.owned.map.add_variance(said_m2) == Status::ok);
    for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.7}, patch(0.5, 1.0, -0.2, 0.2, 0.1));
    return looker.ground(0.77, 0.01);
  };
  CHECK(heights(0.0).low_m == Approx(0.0).margin(1e-5));  // unsaid, it is an edge
  CHECK(heights(0.0).high_m == Approx(0.1).margin(1e-5));
  const GroundSpan one = heights(0.01);
  CHECK(one.low_m == one.high_m);
  CHECK(one.low_m == Approx(0.1).margin(0.005));
}

TEST_CASE("elevation: what large corrections made unsure stays so, however many there are") {
  Looker looker;
  for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
  CHECK(looker.ground(0.77, 0.01).sigma_m < 0.02);
  for (int i = 0; i < 400; ++i) {
    REQUIRE(looker.owned.map.add_variance(0.26 + 0.5 * (i % 2)) == Status::ok);
    CHECK(looker.ground(0.77, 0.01).sigma_m > 0.4);
  }
}

TEST_CASE("elevation: what is not seen any more gets less sure with motion, and does not shift") {
  Looker looker;
  for (int scan = 0; scan < 10; ++scan) looker.look({0, 0, 0.6}, patch(0.5, 1.0, -0.2, 0.2, 0.0));
  const GroundSpan before = looker.ground(0.77, 0.01);
  for (int step = 0; step < 1000; ++step) REQUIRE(looker.owned.map.add_variance(4e-7) == Status::ok);
  const GroundSpan after = looker.ground(0.77, 0.01);
  CHECK(after.high_m == before.high_m);
  CHECK(after.sigma_m * after.sigma_m - before.sigma_m * before.sigma_m == Approx(4e-4).epsilon(0.03));
  CHECK(looker.owned.map.add_variance(kNaN) == Status::not_finite);
  CHECK(looker.owned.map.add_variance(-1) == Status::out_of_range);
}
