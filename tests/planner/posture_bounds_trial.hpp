// SPDX-License-Identifier: BSD-3-Clause
// Grounds that are drawn within the bounds of a course's cells, and the bounds of the posture there.
#pragma once

#include <catch2/catch.hpp>

#include "planner/posture_bounds.hpp"
#include "tests/planner/posture_bounded_course.hpp"
#include "tests/planner/posture_ground_twins.hpp"

namespace sortie::planner {

struct BoundsTally {
  int cases{}, samples{}, outside{}, tips{}, unsettled{}, may_tip{};
};

/// Tries sampled grounds against the bounds of their course.
inline void try_bounds(std::uint64_t seed, double share, double width_m, int samples, BoundsTally& tally) {
  const auto solver = std::make_unique<PostureSolver>(PostureVehicle{}, PostureConfig{});
  const auto bounder = std::make_unique<PostureBounder>();
  hil::Random random(seed, 0x626f756e);
  const BoxCourse course = random_course(kCourseFamilies[seed % 5], random);
  FlipperSet flippers;
  for (double& angle : flippers.angle_rad) angle = random.uniform(-0.6, 1.2);
  const StandPose pose{random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-3, 3)};
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
    // Beyond the tilts that are looked at nothing is promised: that bounds reach to their end is seen, not
    // shown; a search that has not settled found no rest.
    if (p.settled_rad > 1e-3) {
      ++tally.unsettled;
      continue;
    }
    const bool steep = std::max(std::fabs(p.pitch_rad), std::fabs(p.roll_rad)) > PostureBounder::kWidest_rad;
    if (p.rest != Rest::stands || steep) {
      ++tally.tips;
      CHECK(bounds.may_tip);
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

}  // namespace sortie::planner
