// SPDX-License-Identifier: BSD-3-Clause
// Bounds of a posture: no ground within the cells' bounds gives a rest outside of them.
#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/planner/posture_bounds_trial.hpp"

namespace sortie::planner {

TEST_CASE("no ground within the bounds of its cells rests outside of the posture's", "[heavy]") {
  BoundsTally tally;
  for (std::uint64_t seed = 1; seed <= 40; ++seed)
    try_bounds(seed, 0.15 * static_cast<double>(seed % 5), seed % 2 == 0 ? 0.02 : 0.1, 20, tally);
  std::printf(
      "seeds 1..40: %d samples, %d outside, %d tip or steeper than is looked at, %d not settled; %d of %d "
      "may "
      "tip\n",
      tally.samples, tally.outside, tally.tips, tally.unsettled, tally.may_tip, tally.cases);
  CHECK(tally.samples > 500);
}

TEST_CASE("bounds on known ground close around the rest, the tighter the more units", "[planner][posture]") {
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  const FormulaGround flat{[](double, double) { return 0.5; }};
  const FlipperSet flippers{{-0.3, -0.3, -0.3, -0.3}};
  REQUIRE(solver->look(flat.view(), {}) == Status::ok);
  Posture p;
  REQUIRE(solver->rest(flippers, p) == Status::ok);
  double before = 10.0;
  for (const std::uint32_t units : {196u, 512u, 4096u}) {
    PostureBounds b;
    REQUIRE(bounder->bound(*solver, flippers, units, b) == Status::ok);
    CHECK(b.units <= units);
    CHECK(b.bounded);
    CHECK(b.pitch_rad.low <= p.pitch_rad);
    CHECK(b.pitch_rad.high >= p.pitch_rad);
    const double width = b.pitch_rad.high - b.pitch_rad.low;
    CHECK(width <= before);
    before = width;
  }
  CHECK(before < 0.02);
}

TEST_CASE("bounds where nothing is known say so, and a hole that may be one is taken for one",
          "[planner][posture]") {
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  PostureBounds b;
  CHECK(bounder->bound(*solver, {}, 1024, b) == Status::empty);
  const HeightView nothing{nullptr, [](const void*, std::int64_t, std::int64_t) { return HeightCell{}; },
                           0.05};
  REQUIRE(solver->look(nothing, {}) == Status::ok);
  REQUIRE(bounder->bound(*solver, {}, 1024, b) == Status::ok);
  CHECK_FALSE(b.bounded);
  CHECK(b.pitch_rad.high == 0.0);
  CHECK(bounder->bound(*solver, {}, 5, b) == Status::out_of_range);
  // Ahead of the middle the ground is bounded from above alone: the nose may go down as far as is looked at.
  const HeightView cliff{
      nullptr,
      [](const void*, std::int64_t i, std::int64_t) {
        return HeightCell{0.0, 0.0, i < -3 ? HeightState::known : HeightState::bounded_above};
      },
      0.05};
  REQUIRE(solver->look(cliff, {}) == Status::ok);
  REQUIRE(bounder->bound(*solver, {{0.5, 0.5, 0.5, 0.5}}, 2048, b) == Status::ok);
  CHECK(b.may_tip);
  CHECK(b.pitch_rad.high > 0.69);
}

TEST_CASE("bounds on known ground are there on a mountain, too") {
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  const FormulaGround high{[](double, double) { return 3000.0; }};
  REQUIRE(solver->look(high.view(), {}) == Status::ok);
  PostureBounds b;
  REQUIRE(bounder->bound(*solver, {{2.0, 2.0, 2.0, 2.0}}, 2048, b) == Status::ok);
  CHECK(b.bounded);
  CHECK(b.rests);
  CHECK(b.pitch_rad.high < 0.1);
  CHECK(b.height_m.low > 2999.0);
}

}  // namespace sortie::planner
