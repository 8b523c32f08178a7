// SPDX-License-Identifier: BSD-3-Clause
// Courses by case, and the drivers over those for tuning.
#include <stdexcept>

#include "tests/bench/courses/course_parts.hpp"
#include "tests/bench/courses/mission_driver.hpp"
#include "tests/bench/courses/tally.hpp"

namespace sortie::bench {

hil::JudgeConfig bench_rules() {
  hil::JudgeConfig rules;
  rules.stuck_s = 4.0;
  return rules;
}

std::vector<hil::TerrainFamily> families_of(const CourseSettings& settings) {
  std::vector<hil::TerrainFamily> families;
  std::string names;
  for (int f = 0; f < hil::kTerrainFamilies; ++f) {
    const auto family = static_cast<hil::TerrainFamily>(f);
    names += std::string(f > 0 ? ", " : "") + name_of(family);
    if (settings.family.empty() || settings.family == name_of(family)) families.push_back(family);
  }
  if (families.empty()) throw std::invalid_argument("--family takes one of " + names);
  return families;
}

hil::Course course_of(const CourseSettings& settings, hil::CourseUse use, hil::TerrainFamily family, int k) {
  return hil::draw_course(use, family, settings.seed + static_cast<std::uint64_t>(k),
                          (k + 0.5) / settings.cases);
}

std::vector<NamedDriver> other_drivers() {
  std::vector<NamedDriver> drivers;
  drivers.push_back({"mission", std::make_unique<MissionDriver>()});
  drivers.push_back({"operator", std::make_unique<hil::OperatorDriver>()});
  return drivers;
}

namespace {

TuningTable drive_tuning_courses(const CourseSettings& settings) {
  std::vector<NamedDriver> drivers;
  for (const hil::NamedPosture& posture : hil::fixed_postures())
    drivers.push_back(
        {posture.name, std::make_unique<hil::ScriptDriver>(hil::fixed_posture(posture.angles))});
  for (NamedDriver& driver : other_drivers()) drivers.push_back(std::move(driver));
  std::vector<Tally> tallies(drivers.size());
  int courses = 0;
  for (const hil::TerrainFamily family : families_of(settings)) {
    for (int k = 0; k < settings.cases; ++k) {
      const hil::Course course = course_of(settings, hil::CourseUse::tuning, family, k);
      ++courses;
      for (std::size_t d = 0; d < drivers.size(); ++d) {
        const hil::CourseResult result = judge_course(course, *drivers[d].driver, bench_rules());
        tallies[d].count(result);
        if (result.end == hil::CourseEnd::reached) tallies[d].weigh(result);
      }
    }
  }
  TuningTable table;
  for (std::size_t d = 0; d < drivers.size(); ++d) {
    const bool posture = d < hil::fixed_postures().size();
    const hil::PairAngles angles = posture ? hil::fixed_postures()[d].angles : hil::PairAngles{};
    const auto degrees = [&](double rad) {
      return posture ? Json(rounded_to(57.29577951308232 * rad, 1)) : Json("-");
    };
    table.rows.push_back(
        tallies[d].values({drivers[d].name, degrees(angles.front_rad), degrees(angles.rear_rad), courses}));
    const Tally& best = tallies[table.best];
    const bool more = tallies[d].reached > best.reached;
    const bool safer = tallies[d].reached == best.reached && tallies[d].tipped < best.tipped;
    if (posture && (more || safer)) table.best = d;
  }
  return table;
}

}  // namespace

const TuningTable& tuning_table(const CourseSettings& settings) {
  static const TuningTable table = drive_tuning_courses(settings);
  return table;
}

void measure_tuning(const CourseSettings& settings, Report& report) {
  const TuningTable& table = tuning_table(settings);
  report.add_table("tuning", tally_columns({"driver", "front deg", "rear deg", "courses"}), table.rows);
  report.note("tuning", std::string("Best fixed posture: ") + hil::fixed_postures()[table.best].name +
                            ". Rates, accelerations, touches and times are of what was reached: medians, of "
                            "touches the mean.");
}

}  // namespace sortie::bench
