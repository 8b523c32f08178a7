// SPDX-License-Identifier: BSD-3-Clause
// Postures beside the plant at rest. Bounds were chosen on seeds from 1,000,000 on, and are judged on those
// from 1 on.
#include <catch2/catch.hpp>
#include <cstdio>

#include "posture_courses.hpp"

namespace sortie::planner {
namespace {

/// Errors of one family of courses.
struct RestErrors {
  std::vector<double> tilt_deg, height_mm;
  int count{}, no_rest{}, other_rest{}, not_standing{}, off{}, near_edge{};

  void add(const RestError& e) {
    ++count;
    if (!e.rests) {
      ++no_rest;
      return;
    }
    if (e.told != Rest::stands) ++not_standing;
    if (e.other_rest) {
      ++other_rest;
      return;
    }
    tilt_deg.push_back(e.tilt_rad * 57.29577951);
    height_mm.push_back(1e3 * e.height_m);
    if (tilt_deg.back() <= 2.0) return;
    ++off;
    if (e.near_edge) ++near_edge;
  }

  static double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values.empty() ? 0.0
                          : values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }

  void print(const char* name) const {
    std::printf(
        "%-18s %4d poses, %d never at rest, %d another rest, %d not standing; tilt p50 %.2f p90 %.2f p99 "
        "%.2f deg, %d above 2 (%d near an edge); height p50 %.1f p90 %.1f p99 %.1f mm\n",
        name, count, no_rest, other_rest, not_standing, quantile(tilt_deg, 0.5), quantile(tilt_deg, 0.9),
        quantile(tilt_deg, 0.99), off, near_edge, quantile(height_mm, 0.5), quantile(height_mm, 0.9),
        quantile(height_mm, 0.99));
  }
};

void judge_rests(std::uint64_t first, int poses) {
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
    errors.print(kCourseNames[static_cast<int>(family)]);
    INFO(kCourseNames[static_cast<int>(family)] << ", seeds from " << first << " on");
    CHECK(RestErrors::quantile(errors.tilt_deg, 0.5) < 0.5);
    CHECK(RestErrors::quantile(errors.height_mm, 0.5) < 4.0);
  }
  all.print("all");
  CHECK(all.no_rest <= 0.03 * all.count);
  CHECK(all.not_standing <= 0.03 * all.count);
}

}  // namespace

TEST_CASE("postures are those that the plant comes to rest in", "[planner][posture]") { judge_rests(1, 120); }

TEST_CASE("postures are those that the plant comes to rest in, ten thousand of them", "[heavy]") {
  judge_rests(100'001, 2'000);
}

}  // namespace sortie::planner
