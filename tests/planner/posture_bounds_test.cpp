// SPDX-License-Identifier: BSD-3-Clause
// Bounds of a posture: no ground within the cells' bounds gives a rest outside of them.
#include "planner/posture_bounds.hpp"

#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/planner/posture_bounded_course.hpp"
#include "tests/planner/posture_ground_twins.hpp"

namespace sortie::planner {
namespace {

struct BoundsTally {
  int cases{}, samples{}, outside{}, tips{}, unsettled{}, may_tip{};
};

/// Tries sampled grounds against the bounds of their course.
void try_bounds(std::uint64_t seed, double share, double width_m, int samples, BoundsTally& tally) {
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  hil::Random random(seed, 0x626f756e);
  const BoxCourse course = random_course(kCourseFamilies[seed % 5], random);
  FlipperSet flippers;
  for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
  const GroundPose pose{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-3, 3)};
  BoundedCourse ground{&course, share, width_m, seed, 0};
  REQUIRE(solver->look(ground.view(), pose) == Status::ok);
  PostureBounds bounds;
  REQUIRE(bounder->bound(*solver, flippers, 2048, bounds) == Status::ok);
  ++tally.cases;
  if (bounds.may_tip) ++tally.may_tip;
  for (int k = 1; k <= samples; ++k) {
    ground.sample = static_cast<std::uint64_t>(k);
    Posture p;
    REQUIRE(solver->look(ground.view(), pose) == Status::ok);
    REQUIRE(solver->rest(flippers, p) == Status::ok);
    // Beyond the tilts that are looked at nothing is promised but may_tip; a search that has not settled
    // found no rest.
    if (p.settled_rad > 1e-3) {
      ++tally.unsettled;
      continue;
    }
    const bool steep = std::max(std::fabs(p.pitch_rad), std::fabs(p.roll_rad)) > PostureBounder::kWidest_rad;
    if (p.rest != Rest::stands || steep) {
      ++tally.tips;
      continue;
    }
    ++tally.samples;
    const auto within = [](double v, const Range& r) { return v >= r.low - 1e-6 && v <= r.high + 1e-6; };
    const bool inside =
        bounds.rests &&
        (!bounds.bounded ||
         (within(p.pitch_rad, bounds.pitch_rad) && within(p.roll_rad, bounds.roll_rad) &&
          within(p.height_m, bounds.height_m) && p.clearance_m >= bounds.least_clearance_m - 1e-6));
    INFO("seed " << seed << " sample " << k << ": pitch " << p.pitch_rad << " roll " << p.roll_rad
                 << " height " << p.height_m << " settled " << p.settled_rad);
    CHECK(inside);
    if (!inside) ++tally.outside;
  }
}

}  // namespace

TEST_CASE("no ground within the bounds of its cells rests outside of the posture's", "[planner][posture]") {
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

TEST_CASE("no ground within the bounds of its cells rests outside of the posture's, many of them",
          "[heavy]") {
  BoundsTally tally;
  for (std::uint64_t seed = 1001; seed <= 1600; ++seed)
    try_bounds(seed, 0.15 * static_cast<double>(seed % 7), 0.02 * static_cast<double>(1 + seed % 6), 30,
               tally);
  std::printf(
      "seeds 1001..1600: %d samples, %d outside, %d tip or steeper, %d not settled; %d of %d may tip\n",
      tally.samples, tally.outside, tally.tips, tally.unsettled, tally.may_tip, tally.cases);
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
  const GroundView nothing{nullptr, [](const void*, std::int64_t, std::int64_t) { return GroundCell{}; },
                           0.05};
  REQUIRE(solver->look(nothing, {}) == Status::ok);
  REQUIRE(bounder->bound(*solver, {}, 1024, b) == Status::ok);
  CHECK_FALSE(b.bounded);
  CHECK(b.pitch_rad.high == 0.0);
  CHECK(bounder->bound(*solver, {}, 5, b) == Status::out_of_range);
  // Ahead of the middle the ground is bounded from above alone: the nose may go down as far as is looked at.
  const GroundView cliff{
      nullptr,
      [](const void*, std::int64_t i, std::int64_t) {
        return GroundCell{0.0, 0.0, i < -3 ? GroundState::known : GroundState::bounded_above};
      },
      0.05};
  REQUIRE(solver->look(cliff, {}) == Status::ok);
  REQUIRE(bounder->bound(*solver, {{0.5, 0.5, 0.5, 0.5}}, 2048, b) == Status::ok);
  CHECK(b.may_tip);
  CHECK(b.pitch_rad.high > 0.69);
}

}  // namespace sortie::planner
