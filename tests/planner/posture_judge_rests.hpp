// SPDX-License-Identifier: BSD-3-Clause
// Postures beside the plant at rest. Bounds were chosen on seeds from 1,000,000 on, and are judged on those
// from 1 on.
#pragma once

#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/planner/posture_rests.hpp"

namespace sortie::planner {

/// Of each family of courses so many poses, seeds from `first` on.
inline void judge_rests(std::uint64_t first, int poses) {
  const auto solver = std::make_unique<PostureSolver>(posture_vehicle({}), PostureConfig{});
  REQUIRE(solver->usable() == Status::ok);
  RestErrors all;
  for (const CourseFamily family : kCourseFamilies) {
    RestErrors errors;
    for (int k = 0; k < poses; ++k) {
      const RestError e =
          rest_beside_plant(*solver, family, first + static_cast<std::uint64_t>(k), true, 0.05);
      errors.add(e);
      all.add(e);
    }
    std::puts(errors.words(kCourseNames[static_cast<int>(family)]).c_str());
    INFO(kCourseNames[static_cast<int>(family)] << ", seeds from " << first << " on");
    CHECK(RestErrors::quantile(errors.tilt_deg, 0.5) < 0.5);
    CHECK(RestErrors::quantile(errors.height_mm, 0.5) < 4.0);
  }
  std::puts(all.words("all").c_str());
  CHECK(RestErrors::quantile(all.tilt_deg, 0.9) < 2.0);
  CHECK(all.other_rest <= 0.05 * all.count);
  CHECK(all.no_rest <= 0.03 * all.count);
  CHECK(all.not_standing <= 0.03 * all.count);
}

}  // namespace sortie::planner
