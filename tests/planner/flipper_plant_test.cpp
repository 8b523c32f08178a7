// SPDX-License-Identifier: BSD-3-Clause
// The policy in the plant, over the obstacles of the mission's scenes. The policy was made on these: what it
// does on drawn ones is for `sortie bench flippers`.
#include <catch2/catch.hpp>

#include "tests/planner/flipper_drive.hpp"

namespace sortie::planner {

TEST_CASE("flippers: the plant is led over step, pallet and stairs", "[planner][flippers][heavy]") {
  for (const DrivenCourse& course : driven_courses()) {
    const auto policy = flipper_policy();
    const DriveResult led = drive(course, course.ground.view(), policy.get(), {{0.5, 0.5, 0.5, 0.5}}, 0.9);
    std::printf("%s\n  %s\n", course.name, led.words("policy").c_str());
    double best = 1e9;
    for (const FlipperSet& fixed : kFixedPostures) {
      const DriveResult held = drive(course, course.ground.view(), nullptr, fixed, 0.9);
      char what[64];
      std::snprintf(what, sizeof what, "fixed %.1f %.1f", fixed.angle_rad[0], fixed.angle_rad[2]);
      std::printf("  %s\n", held.words(what).c_str());
      if (held.arrived) best = std::min(best, held.peak_pitch_rad_s);
    }
    INFO(course.name);
    CHECK(!led.tipped);
    CHECK(led.belly_s == 0.0);
    if (course.may_stall) {
      // It stalls on the second tread, and says so: known, and told in docs/flippers.md.
      CHECK((led.arrived || led.last == FlipperVerdict::stop));
      continue;
    }
    CHECK(led.arrived);
    CHECK(led.peak_pitch_rad_s < 0.75 * best);
  }
}

}  // namespace sortie::planner
