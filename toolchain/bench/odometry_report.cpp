// SPDX-License-Identifier: BSD-3-Clause
// Tables and plots of the odometry's benchmark.
#include <algorithm>
#include <cmath>
#include <ostream>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/figure_table.hpp"
#include "toolchain/bench/odometry_bench.hpp"

namespace sortie::toolchain {
namespace {

struct Column {
  const char* key;
  const char* title;
  double scale;
};

// In the order of the table; one that no cell has is left out.
constexpr Column kErrorColumns[] = {{"inclination_rmse_deg", "inclination deg", 1},
                                    {"heading_rmse_deg", "heading deg", 1},
                                    {"vertical_rmse_m", "vertical mm", 1e3},
                                    {"ate_rmse_m", "ate m", 1},
                                    {"drift_horizontal_percent", "horizontal drift %", 1},
                                    {"drift_vertical_percent", "vertical drift %", 1}};

TextTable table_of(const OdometrySet& set, const std::vector<OdometryCell>& cells) {
  std::vector<Column> columns;
  for (const Column& column : kErrorColumns) {
    for (const OdometryCell& cell : cells) {
      if (cell.errors.count(column.key) == 0) continue;
      columns.push_back(column);
      break;
    }
  }
  std::vector<std::vector<std::string>> lines{{"rate Hz", "what", "cost us/s"}};
  for (const Column& column : columns)
    lines[0].push_back(column.title + std::string(set.error == column.key ? " (judged)" : ""));
  if (set.has_odometry) lines[0].push_back("slips");
  lines[0].push_back("");
  for (const OdometryCell& cell : cells) {
    std::vector<std::string>& line = lines.emplace_back(std::vector<std::string>{
        firmware::format_fixed(cell.rate_hz, 0), cell.variant, firmware::format_short(cell.cost_us_per_s)});
    for (const Column& column : columns) {
      const auto found = cell.errors.find(column.key);
      line.push_back(found == cell.errors.end() ? "-" : firmware::format_short(column.scale * found->second));
    }
    if (set.has_odometry) line.push_back(firmware::group_digits(cell.slips));
    line.push_back(std::string(cell.on_front ? "front" : "") +
                   (cell.profile_choice ? (cell.on_front ? ", **profile**" : "**profile**") : ""));
  }
  std::vector<bool> words(lines[0].size());
  words[1] = words.back() = true;
  return {std::move(lines), std::move(words)};
}

}  // namespace

void print_odometry(std::ostream& out, const OdometrySet& set, const std::vector<OdometryCell>& cells) {
  out << "\n" << set.name << "\n";
  print_lines(out, table_of(set, cells));
}

std::string odometry_table(const OdometrySet& set, const std::vector<OdometryCell>& cells) {
  return markdown(table_of(set, cells));
}

Plot plot_odometry(const OdometrySet& set, const std::vector<OdometryCell>& cells) {
  const bool vertical = set.error == "vertical_rmse_m";
  const char* const error_name = vertical                              ? "vertical error, mm rms"
                                 : set.error == "inclination_rmse_deg" ? "inclination error, deg rms"
                                                                       : "position error, m rms";
  Plot plot{set.name + ": error over run time; a line a variant, its points the rates",
            {"processor time, \u00b5s per second of robot time", true},
            {error_name, true},
            640,
            380};
  Series front{"Pareto front", Mark::dots, kBlack, 3};
  Series own{"profile", Mark::dots, kVermilion, 7};
  int colour = 0;
  std::vector<Series> lines;
  for (const char* variant : kOdometryVariants) {
    Series line{variant, Mark::line, colour++};
    for (const OdometryCell& cell : cells) {
      const auto found = cell.errors.find(set.error);
      if (cell.variant != variant || found == cell.errors.end()) continue;
      const double error = (vertical ? 1e3 : 1.0) * found->second;
      line.add(cell.cost_us_per_s, error);
      if (cell.on_front) front.add(cell.cost_us_per_s, error);
      if (cell.profile_choice) own.add(cell.cost_us_per_s, error);
    }
    if (!line.x.empty()) lines.push_back(std::move(line));
  }
  plot.series.push_back(std::move(own));
  for (Series& line : lines) plot.series.push_back(std::move(line));
  plot.series.push_back(std::move(front));
  return plot;
}

Plot plot_heights(const OdometrySet& set) {
  const double every = set.profile_rate_hz > 0.0 ? set.rate_hz / set.profile_rate_hz : 1.0;
  const OdometrySet own = thinned(set, static_cast<std::uint32_t>(std::lround(every)));
  Plot plot{set.name + ": height along the way", {"distance, m"}, {"height, m"}};
  Series truth{"truth", Mark::line, kBlack, 2.4};
  const std::pair<const char*, Series> lines[] = {
      {"no obstacle modes", {"plain method", Mark::line, kVermilion, 1.6, true}},
      {"all, double", {"with obstacle modes", Mark::line, kBlue}}};
  for (const auto& [variant, look] : lines) {
    const PairedTrajectories pairs = associate(run_odometry_variant(own, variant), own.truth);
    Series line = look;
    double way = 0.0;
    for (std::size_t i = 0; i < pairs.truth.size(); ++i) {
      const firmware::TimedPose& now = pairs.truth[i];
      const firmware::TimedPose& before = pairs.truth[i > 0 ? i - 1 : 0];
      way += std::hypot(now.p[0] - before.p[0], now.p[1] - before.p[1], now.p[2] - before.p[2]);
      line.add(way, pairs.estimate[i].p[2]);
      if (&look == &lines[0].second) truth.add(way, now.p[2]);
    }
    plot.series.push_back(std::move(line));
  }
  plot.series.insert(plot.series.begin(), std::move(truth));
  return plot;
}

firmware::Json to_json(const std::vector<OdometryCell>& cells) {
  firmware::Json rows = firmware::Json::array();
  for (const OdometryCell& cell : cells) {
    rows.push_back({{"set", cell.set},
                    {"variant", cell.variant},
                    {"rate_hz", cell.rate_hz},
                    {"cost_us_per_s", cell.cost_us_per_s},
                    {"errors", cell.errors},
                    {"slips", cell.slips},
                    {"front", cell.on_front},
                    {"profile", cell.profile_choice}});
  }
  return rows;
}

}  // namespace sortie::toolchain
