// SPDX-License-Identifier: BSD-3-Clause
// The drivers over courses for judging.
#include "tests/bench/courses/course_parts.hpp"
#include "tests/bench/courses/tally.hpp"

namespace sortie::bench {

void measure_drivers(const CourseSettings& settings, Report& report) {
  using hil::CourseEnd;
  const hil::NamedPosture& best = hil::fixed_postures()[tuning_table(settings).best];
  std::vector<NamedDriver> drivers;
  drivers.push_back({std::string("fixed ") + best.name,
                     std::make_unique<hil::ScriptDriver>(hil::fixed_posture(best.angles))});
  for (NamedDriver& driver : other_drivers()) drivers.push_back(std::move(driver));
  Json rows = Json::array();
  std::vector<Tally> all(drivers.size());
  std::vector<Tally> same(drivers.size());  // of the courses that all drivers pass
  int courses = 0, passables = 0, common = 0;
  for (const hil::TerrainFamily family : families_of(settings)) {
    std::vector<Tally> tallies(drivers.size());
    int passable = 0;
    for (int k = 0; k < settings.cases; ++k) {
      const hil::Course course = course_of(settings, hil::CourseUse::judging, family, k);
      std::vector<hil::CourseResult> results;
      int reached = 0;
      for (std::size_t d = 0; d < drivers.size(); ++d) {
        results.push_back(judge_course(course, *drivers[d].driver, bench_rules()));
        tallies[d].count(results[d]);
        all[d].count(results[d]);
        if (results[d].end != CourseEnd::reached) continue;
        ++reached;
        tallies[d].weigh(results[d]);
        all[d].weigh(results[d]);
      }
      ++courses;
      if (reached > 0 || grid_passes(course, bench_rules())) ++passable;
      if (reached < static_cast<int>(drivers.size())) continue;
      ++common;
      for (std::size_t d = 0; d < drivers.size(); ++d) {
        same[d].count(results[d]);
        same[d].weigh(results[d]);
      }
    }
    passables += passable;
    for (std::size_t d = 0; d < drivers.size(); ++d)
      rows.push_back(tallies[d].values({name_of(family), drivers[d].name, settings.cases, passable}));
  }
  for (std::size_t d = 0; d < drivers.size(); ++d)
    rows.push_back(all[d].values({"all", drivers[d].name, courses, passables}));
  for (std::size_t d = 0; d < drivers.size(); ++d)
    rows.push_back(same[d].values({"passed by all", drivers[d].name, common, common}));
  report.add_table("drivers", tally_columns({"family", "driver", "courses", "passable"}), rows);
  report.note("drivers",
              "Courses for judging. Passable: a driver of the table or one of " +
                  std::to_string(hil::script_grid().size()) +
                  " scripts reaches the goal. Other: stuck, out of the ellipse, turned away. Rates, "
                  "accelerations, touches and times are of what was reached: medians, of touches the mean.");
}

}  // namespace sortie::bench
