// SPDX-License-Identifier: BSD-3-Clause
// Error over run time for what a step is made of: returns, steps, edge of a cell.
#include <cmath>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_sets.hpp"
#include "tests/bench/report/front.hpp"

namespace sortie::bench {
namespace {

constexpr std::uint32_t kReturns[] = {128, 256, 512, 1024, 2048, 4096};
constexpr std::uint32_t kSteps[] = {2, 4, 6, 8, 12};
constexpr double kCells_m[] = {0.2, 0.3, 0.4, 0.5, 0.7, 1.0};

FrontCell measure(const mapping::RegistrationConfig& config, const std::vector<MapAndScans>& sets) {
  const MatchedSteps steps = matched_steps(config, sets);
  FrontCell cell;
  cell.curve = "cell " + decimals(config.cell_m, 1) + " m";
  cell.label = std::to_string(config.returns) + ", " + std::to_string(config.steps);
  cell.cost = steps.ms.median();
  cell.error = steps.mm.quantile(0.95);
  cell.row = {decimals(config.cell_m, 1), config.returns, config.steps};
  for (const std::string& text : steps.columns()) cell.row.push_back(text);
  return cell;
}

void sweep(Report& report, const std::string& name, const std::string& file,
           const std::vector<MapAndScans>& sets) {
  std::vector<FrontCell> cells;
  for (const double cell_m : kCells_m) {
    for (const std::uint32_t returns : kReturns) {
      for (const std::uint32_t steps : kSteps) {
        mapping::RegistrationConfig config;
        config.cell_m = cell_m;
        config.returns = returns;
        config.steps = steps;
        cells.push_back(measure(config, sets));
      }
    }
  }
  cells.push_back(measure({}, sets));
  cells.back().by_itself = true;
  const Picture picture{"bench-registration-" + file,
                        "sweep, " + name,
                        "Error over run time, " + name,
                        "run time of a step, median, ms",
                        "95 % of errors are below, mm",
                        true,
                        true,
                        false,
                        {}};
  std::vector<std::string> columns{"cell m", "returns", "steps"};
  for (const char* const column : MatchedSteps::kColumns) columns.emplace_back(column);
  add_front(report, picture, columns, cells, FrontRows::front);
}

}  // namespace

void measure_registration_sweep(const RegistrationSettings& settings, Report& report) {
  const int halls = std::max(1, settings.cases_or(40) / 5);
  const StartError off{0.2, 5 * M_PI / 180, false};
  sweep(report, "halls", "halls", hall_set(halls, 5, off, settings.seed));
  const auto recorded = recorded_set(settings.data, off, settings.seed);
  if (recorded.empty()) {
    report.skip("sweep on the recorded drive", "lidar_os64 is not in " + settings.data);
  } else {
    sweep(report, "recorded drive", "recorded", recorded);
  }
}

}  // namespace sortie::bench
