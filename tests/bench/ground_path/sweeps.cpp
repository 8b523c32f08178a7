// SPDX-License-Identifier: BSD-3-Clause
// The ground planner's cost over budget, over the size of a cell, and over what was not seen.
#include <cmath>

#include "tests/bench/ground_path/ground_course.hpp"
#include "tests/bench/ground_path/ground_parts.hpp"
#include "tests/bench/report/picture.hpp"

namespace sortie::bench {
namespace {

using planner::GroundPathState;
using planner::test::OwnedGround;

GroundHall hall_of(const GroundSettings& settings, std::uint64_t i) {
  return draw_hall(static_cast<std::uint32_t>(settings.seed + i));
}

// The cost that was there after so many units; negative: none.
double cost_after(const GroundCourse& course, std::uint64_t units) {
  double cost = -1.0;
  for (const CourseStep& step : course.steps)
    if (step.units <= units) cost = step.cost_s;
  return cost;
}

// Patches that were not seen, until about a share of the hall is; never where start and goal are.
void forget_some(OwnedGround& ground, double share, std::uint32_t seed) {
  std::mt19937 random(seed);
  const std::int32_t n = ground.config.nx;
  for (std::int32_t unseen = 0; unseen < static_cast<std::int32_t>(share * n * n);) {
    const std::int32_t x0 = planner::test::draw_below(random, n);
    const std::int32_t y0 = planner::test::draw_below(random, n);
    const std::int32_t size = 3 + planner::test::draw_below(random, 10);
    for (std::int32_t y = y0; y < std::min(y0 + size, n); ++y) {
      for (std::int32_t x = x0; x < std::min(x0 + size, n); ++x) {
        if (x < n / 6 || x > 5 * n / 6 || ground.map.cell(x, y).is_unknown()) continue;
        ground.set(x, y, planner::GroundState::unknown);
        ++unseen;
      }
    }
    if (share > 0.6) break;  // more than the middle holds
  }
}

}  // namespace

void measure_ground_budget(const GroundSettings& settings, Report& report) {
  std::vector<GroundCourse> courses;
  for (std::uint64_t i = 0; i < settings.maps; ++i) {
    const GroundHall hall = hall_of(settings, i);
    OwnedGround ground(hall_config(hall, 100), hall_room());
    lay_out(hall, ground);
    courses.push_back(run_course(ground, hall_start(hall, 100), hall_goal(hall, 100)));
    if (courses.back().state != GroundPathState::proved) courses.pop_back();
  }
  Json rows = Json::array();
  Picture picture{"bench-ground-path-budget",
                  "budget",
                  "Cost over budget",
                  "work units",
                  "cost over the optimum",
                  true,
                  false,
                  false,
                  {}};
  Curve median{"median", {}, {}, {}, "", -1};
  Curve worst{"worst", {}, {}, {}, "", -1};
  for (const std::uint64_t units :
       {50'000, 100'000, 150'000, 200'000, 300'000, 400'000, 600'000, 1'000'000, 2'000'000, 4'000'000}) {
    Rounds over;
    std::uint64_t proved = 0;
    for (const GroundCourse& course : courses) {
      const double cost = cost_after(course, units);
      if (cost >= 0) over.add(cost / course.steps.back().cost_s);
      proved += course.end_units <= units ? 1 : 0;
    }
    if (over.empty()) {
      rows.push_back({units, 0, "-", "-", proved});
      continue;
    }
    rows.push_back({units, over.size(), over.median(), over.high(), proved});
    median.x.push_back(static_cast<double>(units));
    median.y.push_back(over.median());
    worst.x.push_back(static_cast<double>(units));
    worst.y.push_back(over.high());
  }
  picture.curves = {median, worst};
  report.add_table("budget", {"units", "ways", "cost over optimum", "worst", "proved"}, rows);
  add_picture(report, picture);
  double ns = 0.0;
  double units = 0.0;
  for (const GroundCourse& course : courses) {
    ns += 1e6 * course.end_ms;
    units += static_cast<double>(course.end_units);
  }
  char words[120];
  std::snprintf(words, sizeof(words), "%zu halls that can be crossed; a unit took %.0f ns.", courses.size(),
                units > 0 ? ns / units : 0.0);
  report.note("budget", words);
}

void measure_ground_resolution(const GroundSettings& settings, Report& report) {
  Json rows = Json::array();
  for (const std::int32_t cell_mm : {50, 100, 200}) {
    Rounds cost_s;
    Rounds first_ms;
    Rounds near_ms;
    Rounds proved_ms;
    std::uint64_t ways = 0;
    double mib = 0.0;
    for (std::uint64_t i = 0; i < settings.maps; ++i) {
      const GroundHall hall = hall_of(settings, i);
      OwnedGround ground(hall_config(hall, cell_mm), hall_room());
      lay_out(hall, ground);
      mib = static_cast<double>(ground.block.size()) / 1048576.0;
      const GroundCourse course = run_course(ground, hall_start(hall, cell_mm), hall_goal(hall, cell_mm));
      if (course.state != GroundPathState::proved) continue;
      ++ways;
      cost_s.add(course.steps.back().cost_s);
      first_ms.add(course.steps.front().ms);
      near_ms.add(reached_ms(course.steps, 1.05 * course.steps.back().cost_s));
      proved_ms.add(course.end_ms);
    }
    if (ways == 0) {
      rows.push_back({cell_mm, 0, "-", "-", "-", "-", mib});
      continue;
    }
    rows.push_back(
        {cell_mm, ways, cost_s.median(), first_ms.median(), near_ms.median(), proved_ms.median(), mib});
  }
  report.add_table(
      "resolution",
      {"cell mm", "ways", "cost s", "first way ms", "to 1.05 ms", "proved ms", "MiB at the most"}, rows);
  report.note("resolution",
              "The same halls, medians. Coarse cells widen what the robot needs by about a cell at each "
              "side, so doors "
              "close. Memory with a column for every surface; a mission has fewer.");
}

void measure_ground_unknown(const GroundSettings& settings, Report& report) {
  Json rows = Json::array();
  for (const double share : {0.0, 0.1, 0.2, 0.3}) {
    for (const auto unknown : {planner::UnknownGround::blocked, planner::UnknownGround::by_price,
                               planner::UnknownGround::look_first}) {
      std::uint64_t ways = 0;
      std::uint64_t known = 0;
      Rounds drivable;
      Rounds cost_s;
      for (std::uint64_t i = 0; i < settings.maps; ++i) {
        const GroundHall hall = hall_of(settings, i);
        planner::GroundPathConfig config = hall_config(hall, 100);
        config.unknown = unknown;
        OwnedGround ground(config, hall_room());
        lay_out(hall, ground);
        forget_some(ground, share, static_cast<std::uint32_t>(settings.seed + i));
        if (ground.plan(hall_start(hall, 100), hall_goal(hall, 100)) != GroundPathState::proved) continue;
        ++ways;
        const auto way = ground.path.way();
        const auto part = ground.path.drivable();
        known += part.size() == way.size() ? 1 : 0;
        cost_s.add(cost_seconds(ground.path.cost()));
        drivable.add(part.empty() ? 0.0 : 100.0 * part.back().cost / std::max(1u, way.back().cost));
      }
      const char* const names[] = {"blocked", "by price", "look first"};
      const char* const name = names[static_cast<std::size_t>(unknown)];
      if (ways == 0)
        rows.push_back({100 * share, name, 0, 0, "-", "-"});
      else
        rows.push_back({100 * share, name, ways, known, cost_s.median(), drivable.median()});
    }
  }
  report.add_table("unknown", {"not seen %", "unknown", "ways", "all known", "cost s", "drivable %"}, rows);
}

}  // namespace sortie::bench
