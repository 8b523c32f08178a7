// SPDX-License-Identifier: BSD-3-Clause
// What a lidar sees of a place: fields of view, rows, and returns thinned to few.
#include <cmath>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
namespace {

constexpr double kRad = M_PI / 180;

struct FieldOfView {
  const char* name;
  double turn_deg, up_deg;
};
constexpr FieldOfView kFields[] = {
    {"360 x 69 deg", 360, 69}, {"120 x 69 deg", 120, 69}, {"87 x 58 deg", 87, 58}};
constexpr int kRows[] = {128, 64, 32, 16};
constexpr std::uint32_t kReturns[] = {mapping::RegistrationConfig{}.returns, 128};

FrontCell measure(const FieldOfView& field, int rows, std::uint32_t returns,
                  const std::vector<MapAndScans>& sets) {
  mapping::RegistrationConfig config;
  config.returns = returns;
  const MatchedSteps steps = matched_steps(config, sets);
  const std::size_t seen = sets.front().scans.front().points.size();
  FrontCell cell;
  cell.curve = std::string(field.name) + (returns == 128 ? ", 128 returns" : "");
  cell.label = std::to_string(rows) + " rows";
  cell.cost = steps.ms.median();
  cell.error = steps.mm.quantile(0.95);
  cell.row = {field.name, rows, seen, returns};
  for (const std::string& text : steps.columns()) cell.row.push_back(text);
  cell.row.push_back(decimals(100.0 * steps.weak / static_cast<double>(steps.ms.size()), 0) + " %");
  return cell;
}

/// `sets_of`: what is seen in a field with so many rows.
template <class SetsOf>
void fields(Report& report, const char* name, const char* file, SetsOf&& sets_of) {
  std::vector<FrontCell> cells;
  for (const FieldOfView& field : kFields) {
    for (const int rows : kRows) {
      const std::vector<MapAndScans> sets = sets_of(field, rows);
      if (sets.empty()) return;
      for (const std::uint32_t returns : kReturns) cells.push_back(measure(field, rows, returns, sets));
    }
  }
  const std::string group = std::string("fields, ") + name;
  const Picture picture{std::string("bench-registration-") + file,
                        group,
                        std::string("Field of view and rows, ") + name,
                        "run time of a step, median, ms",
                        "95 % of errors are below, mm",
                        true,
                        true,
                        false,
                        {}};
  std::vector<std::string> columns{"field of view", "rows", "returns", "matched at most"};
  for (const char* const column : MatchedSteps::kColumns) columns.emplace_back(column);
  columns.emplace_back("not held in all directions");
  add_front(report, picture, columns, cells, FrontRows::all);
  report.note(group,
              "Starts 0.2 m and 5 degrees off. Where a scan does not hold a direction, the error along it is "
              "that of the start: the last column says how often one was named. The recorded sweep is "
              "matched with itself: every other column is the map, those between are the scan.");
}

}  // namespace

void measure_registration_fields(const RegistrationSettings& settings, Report& report) {
  const StartError off{0.2, 5 * kRad, false};
  const int halls = std::max(1, settings.cases_or(60) / 5);
  fields(report, "halls", "fields-halls", [&](const FieldOfView& field, int rows) {
    testing::TestLidar lidar;
    lidar.rows = rows;
    lidar.columns = static_cast<int>(field.turn_deg);
    lidar.low_rad = -0.5 * field.up_deg * kRad;
    lidar.high_rad = 0.5 * field.up_deg * kRad;
    lidar.turn_rad = field.turn_deg * kRad;
    return hall_set(halls, 5, off, settings.seed, lidar);
  });
  const auto sweep = [&](const FieldOfView& field, int rows) {
    return sweep_set(settings.data, {field.turn_deg * kRad, field.up_deg * kRad, 128 / rows},
                     settings.cases_or(60), off, settings.seed);
  };
  if (sweep(kFields[0], 128).empty())
    report.skip("fields of a recorded sweep", "tradr_robot is not in " + settings.data);
  else
    fields(report, "a sweep of the TRADR robot", "fields-sweep", sweep);
}

}  // namespace sortie::bench
