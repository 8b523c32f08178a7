// SPDX-License-Identifier: BSD-3-Clause
// A course that is known between bounds only, and grounds drawn within them.
#pragma once

#include "tests/planner/posture_courses.hpp"

namespace sortie::planner {

/// A course of which a share of the cells is known between bounds only; sample 0 tells the bounds, others a
/// ground within them, at their ends as often as between.
struct BoundedCourse {
  const BoxCourse* course{};
  double share{}, width_m{};
  std::uint64_t seed{}, sample{};

  static HeightCell cell(const void* ground, std::int64_t i, std::int64_t j) {
    const auto& self = *static_cast<const BoundedCourse*>(ground);
    const double middle = BoxCourse::cell(self.course, i, j).high_m;
    const auto place = static_cast<std::uint64_t>((i + 5000) * 10'000 + j + 5000);
    hil::Random bounds(self.seed * 1'000'003 + place, 1);
    double low = middle, high = middle;
    if (bounds.chance(self.share)) {
      low -= self.width_m * bounds.uniform();
      high += self.width_m * bounds.uniform();
    }
    if (self.sample == 0) return {low, high, HeightState::known};
    hil::Random drawn(self.seed * 1'000'003 + place, 1 + self.sample);
    const double h = drawn.chance(0.5) ? (drawn.chance(0.5) ? low : high) : drawn.uniform(low, high);
    return {h, h, HeightState::known};
  }
  HeightView view() const { return {this, &BoundedCourse::cell, 0.05}; }
};

}  // namespace sortie::planner
