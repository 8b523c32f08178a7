// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include "tests/bench/registration/matched_step.hpp"
#include "tests/bench/registration/registration_parts.hpp"
#include "tests/bench/registration/scan_sets.hpp"
#include "tests/bench/report/figures.hpp"
#include "toolchain/judge/pareto.hpp"
#include "toolchain/report/svg.hpp"

namespace sortie::bench {
namespace {

constexpr std::uint32_t kReturns[] = {128, 256, 512, 1024, 2048, 4096};
constexpr std::uint32_t kSteps[] = {2, 4, 6, 8, 12};
constexpr double kCells_m[] = {0.2, 0.3, 0.4, 0.5, 0.7, 1.0};

struct SweepCell {
  std::uint32_t returns{}, steps{};
  double cell_m{}, ms{}, p99_ms{}, mm{}, p95_mm{}, right{};
  bool front{}, by_itself{};
};

SweepCell measure(const mapping::RegistrationConfig& config, const std::vector<MapAndScans>& sets) {
  Rounds ms, mm;
  int right = 0;
  for (const MapAndScans& set : sets) {
    const auto map = map_of(set, config);
    for (std::size_t i = 0; i < set.scans.size(); ++i) {
      const MatchedStep step = matched_step(*map, set.scans[i].points, set.starts[i], 0.0);
      const PoseError error = pose_error(step.match.pose, set.scans[i].pose);
      ms.add(step.ms);
      mm.add(1e3 * error.move_m);
      right += error.within(0.02, 0.2) ? 1 : 0;
    }
  }
  return {config.returns,
          config.steps,
          config.cell_m,
          ms.median(),
          ms.quantile(0.99),
          mm.median(),
          mm.quantile(0.95),
          right / static_cast<double>(mm.size()),
          false,
          false};
}

void print(const char* name, const std::vector<SweepCell>& cells) {
  std::printf(
      "\n## %s: the front, and the defaults\n\n| cell m | returns | steps | ms median | p99 | mm median | mm "
      "95 "
      "%% | within 2 cm, 0.2 deg | |\n|---:|---:|---:|---:|---:|---:|---:|---:|---|\n",
      name);
  for (const SweepCell& c : cells) {
    if (!c.front && !c.by_itself) continue;
    std::printf("| %.1f | %u | %u | %.2f | %.2f | %.2f | %.1f | %.1f %% | %s |\n", c.cell_m, c.returns,
                c.steps, c.ms, c.p99_ms, c.mm, c.p95_mm, 100 * c.right, c.by_itself ? "defaults" : "front");
  }
}

void draw(const char* name, const std::vector<SweepCell>& cells, const std::string& path) {
  toolchain::Plot plot;
  plot.title = std::string("Error over run time, ") + name;
  plot.x = {"run time of a step, median, ms", true};
  plot.y = {"95 % of errors are below, mm", true};
  plot.width = 860;
  plot.height = 460;
  int colour = 0;
  for (const double cell_m : kCells_m) {
    toolchain::Series series;
    char text[32];
    std::snprintf(text, sizeof text, "cell %.1f m", cell_m);
    series.name = text;
    series.mark = toolchain::Mark::dots;
    series.colour = colour == toolchain::kBlack ? toolchain::kGrey : colour;
    series.width = 3;
    ++colour;
    for (const SweepCell& c : cells) {
      if (c.cell_m != cell_m || c.by_itself) continue;
      series.x.push_back(c.ms);
      series.y.push_back(c.p95_mm);
      std::snprintf(text, sizeof text, "%u, %u", c.returns, c.steps);
      series.labels.push_back(c.front ? text : "");
    }
    plot.series.push_back(series);
  }
  toolchain::Series defaults;
  defaults.mark = toolchain::Mark::dots;
  defaults.colour = toolchain::kBlack;
  defaults.width = 5;
  for (const SweepCell& c : cells) {
    if (!c.by_itself) continue;
    defaults.x.push_back(c.ms);
    defaults.y.push_back(c.p95_mm);
    defaults.labels.emplace_back("defaults");
  }
  plot.series.push_back(defaults);
  std::ofstream(path) << toolchain::render(plot);
}

void sweep(const char* name, const std::vector<MapAndScans>& sets, const std::string& path) {
  std::vector<SweepCell> cells;
  const mapping::RegistrationConfig by_itself;
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
  std::vector<toolchain::CostAndError> costs;
  for (const SweepCell& cell : cells) costs.push_back({cell.ms, cell.p95_mm});
  const std::vector<bool> front = toolchain::measured_front(costs);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].front = front[i];
  cells.push_back(measure(by_itself, sets));
  cells.back().by_itself = true;
  print(name, cells);
  if (!path.empty()) draw(name, cells, path);
}

}  // namespace

void registration_sweep(const RegistrationSettings& settings) {
  const int halls = std::max(1, (settings.cases > 0 ? settings.cases : 40) / 5);
  const StartError off{0.2, 5 * M_PI / 180, false};
  const auto file = [&settings](const char* name) {
    return settings.out.empty() ? std::string() : settings.out + "/bench-registration-" + name + ".svg";
  };
  sweep("halls", hall_set(halls, 5, off, settings.seed), file("halls"));
  const auto recorded = recorded_set(settings.data, off, settings.seed);
  if (!recorded.empty()) sweep("recorded drive", recorded, file("recorded"));
}

}  // namespace sortie::bench
