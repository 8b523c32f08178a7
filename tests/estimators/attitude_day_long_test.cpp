// SPDX-License-Identifier: BSD-3-Clause
// A day at 100 Hz.
#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>

#include "tests/estimators/attitude_day.hpp"

TEST_CASE("A day at 100 Hz in float: level within 0.12 deg, length within 5e-7, heading as in double",
          "[long]") {
  using sortie::estimators::test::DayErrors;
  for (const bool moving : {false, true}) {
    const DayErrors errors = sortie::estimators::test::run_day(24, moving);
    std::clog << (moving ? "moving" : "at rest") << ": inclination " << errors.inclination_deg[1]
              << " deg (double " << errors.inclination_deg[0] << "), heading " << errors.heading_deg[1]
              << " deg (double " << errors.heading_deg[0] << "), length " << errors.length[1] << "\n";
    CHECK(errors.inclination_deg[1] < 0.12);
    CHECK(errors.length[1] < 5e-7);
    CHECK(std::fabs(errors.heading_deg[1] - errors.heading_deg[0]) < 0.1 * std::fabs(errors.heading_deg[0]));
  }
}
