// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/page_sections.hpp"

namespace sortie::toolchain {

std::string overview(const std::vector<ReportInput>& inputs) {
  std::string out =
      "<table><thead><tr><th>run</th><th>vehicle</th><th class=\"n\">duration, s</th><th class=\"n\">way, "
      "m</th><th class=\"n\">ate rmse, m</th><th class=\"n\">drift, %</th><th class=\"n\">worst p99 "
      "of its budget</th><th class=\"n\">jobs missed</th><th>digest</th></tr></thead>\n<tbody>";
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const firmware::Results& r = inputs[i].results;
    const auto error = [&r](const char* key) {
      const auto found = r.errors.find(key);
      return found == r.errors.end() ? std::string("-") : firmware::format_short(found->second);
    };
    double worst = 0.0;
    std::uint64_t missed = 0;
    for (const firmware::TaskResult& task : r.tasks) {
      worst = std::max(worst, task.budget_us > 0.0 ? task.p99_us / task.budget_us : 0.0);
      missed += task.missed;
    }
    out += "<tr><td class=\"t\"><a href=\"#run" + std::to_string(i + 1) + "\">" +
           escape_xml(scene_name(inputs[i])) + "</a></td>" + table_cell(r.vehicle, "t") +
           table_cell(firmware::format_short(r.duration_s)) + table_cell(error("distance_m")) +
           table_cell(error("ate_rmse_m")) + table_cell(error("drift_horizontal_percent")) +
           table_cell(firmware::format_fixed(100.0 * worst, 0) + " %") +
           table_cell(firmware::group_digits(missed)) + table_cell(r.digest, "t") + "</tr>\n";
  }
  return out +
         "</tbody></table>\n<p class=\"note\">Of its budget: the 99th percentile of the run time of the task "
         "that comes nearest to it.</p>\n";
}

Plot plot_ways(const std::vector<ReportInput>& inputs, const Plot& ground) {
  constexpr int kWayColours[] = {1, 0, 2, 3, 4};
  Plot plot = ground;
  plot.title = "Where they went, from above";
  plot.x.label = "x, m";
  plot.y.label = "y, m";
  plot.equal_aspect = true;
  plot.width = 980;
  if (ground.series.empty()) plot.height = 480;
  plot.series.erase(std::remove_if(plot.series.begin(), plot.series.end(),
                                   [](const Series& series) { return series.mark != Mark::dots; }),
                    plot.series.end());
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    Series way{scene_name(inputs[i]), Mark::line, kWayColours[i % std::size(kWayColours)], 2.4};
    const auto& path = inputs[i].estimate.empty() ? inputs[i].located : inputs[i].estimate;
    for (const firmware::TimedPose& pose : path) way.add(pose.p[0], pose.p[1]);
    if (!way.x.empty()) plot.series.push_back(std::move(way));
  }
  return plot;
}

}  // namespace sortie::toolchain
