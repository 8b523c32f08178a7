// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "toolchain/report/svg.hpp"
#include "toolchain/sweep/sweep_report.hpp"

namespace sortie::toolchain {

namespace {

// A log axis where the figures span more than a factor of ten: then all of them are told apart.
bool wants_log(const Extent& values) { return values.low > 0 && values.high > 10 * values.low; }

std::string axis_name(const std::string& error) {
  if (error == "map_disagreement") return "occupied volume not shared with finest";
  std::string name = error.substr(0, error.rfind('_'));
  std::replace(name.begin(), name.end(), '_', ' ');
  if (error.ends_with("_m")) return name + ", m";
  if (error.ends_with("_deg")) return name + ", degrees";
  if (error.ends_with("_percent")) return name + ", %";
  name = error;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

// What stands against the run time: without an error the memory, MB.
double height_of(const Sweep& sweep, const SweepCell& cell) {
  if (sweep.error.empty()) return static_cast<double>(cell.memory_bytes) * 1e-6;
  const auto found = cell.errors.find(sweep.error);
  return found != cell.errors.end() ? found->second : std::nan("");
}

// From zero, so that a difference that hardly is one looks like it.
Axis axis_over(std::string name, const std::vector<double>& values) {
  Extent extent;
  extent.take(values);
  Axis axis{std::move(name), wants_log(extent)};
  if (axis.log || !(extent.high > 0)) return axis;
  axis.low = 0;
  axis.high = 1.08 * extent.high;
  return axis;
}

// The line below which no cell lies.
Series steps_of(std::vector<std::pair<double, double>> path) {
  Series steps{"", Mark::steps, kBlue, 1.2, true};
  std::sort(path.begin(), path.end());
  for (const auto& [x, y] : path) steps.add(x, y);
  return steps;
}

}  // namespace

Plot plot_sweep(const Sweep& sweep) {
  Plot plot;
  std::string tasks;
  for (const std::string& task : sweep.tasks) tasks += (tasks.empty() ? "" : " + ") + task;
  plot.title = listed(sweep.keys) + " (" + sweep.scene + ")";
  Series others{"tried", Mark::dots, kGrey, 4};
  Series front{"Pareto front", Mark::dots, kBlue, 4};
  Series own{"profile", Mark::dots, kVermilion, 6};
  std::vector<double> costs;
  std::vector<double> heights;
  std::vector<std::pair<double, double>> path;
  for (const SweepCell& cell : sweep.cells) {
    costs.push_back(cell.load_us_per_s);
    heights.push_back(height_of(sweep, cell));
    Series& series = cell.on_front ? front : others;
    series.add(costs.back(), heights.back());
    series.labels.push_back(listed(cell.values));
    if (cell.on_front) path.emplace_back(costs.back(), heights.back());
    if (cell.profile_choice) own.add(costs.back(), heights.back());
  }
  plot.x = axis_over("run time of " + tasks + ", \u00b5s per second of robot time", costs);
  plot.y = axis_over(sweep.error.empty() ? "memory, MB" : axis_name(sweep.error), heights);
  plot.series = {std::move(own), steps_of(std::move(path))};  // a ring around the dot that comes after
  if (!others.x.empty()) plot.series.push_back(std::move(others));
  if (!front.x.empty()) plot.series.push_back(std::move(front));
  plot.height = 360;
  return plot;
}

}  // namespace sortie::toolchain
