// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/uav_bench.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "firmware_like/bench/figure_passes.hpp"
#include "firmware_like/bench/figure_table.hpp"
#include "firmware_like/bench/peer_program.hpp"

namespace sortie::firmware {

namespace {

std::vector<std::string> uav_conditions(const Json& result) {
  std::vector<std::string> lines;
  lines.push_back("machine   " + result.value("machine", "") + "; " + result.value("compiler", ""));
  const Json settings = result.value("settings", Json::object());
  lines.push_back("settings  " + std::to_string(settings.value("seeds", 0)) + " seeds, " +
                  std::to_string(settings.value("fleet", 0)) + " drawn vehicles, load average " +
                  result.value("load_before", "?") + " before, " + result.value("load_after", "?") +
                  " after" + passes_words(result));
  if (result.contains("doctor")) lines.push_back("doctor    " + result["doctor"].value("summary", ""));
  return lines;
}

// What a part is about, before its tables.
std::string uav_heading(const std::string& group) {
  constexpr const char* kHeadings[][2] = {
      {"peers", "The same flights as Lee's controller"},
      {"stress", "One stress at a time"},
      {"moves", "Goals"},
      {"lost rotor", "One rotor of six lost in hover, undeclared"},
      {"fleet", "Vehicles that nobody tuned for"},
      {"estimated", "On estimates"},
      {"orders", "Error against run time: estimators"},
      {"rates", "Error against run time: control rates, with the observer and without"},
      {"plant", "Error against run time: the plant's integrator and step"},
      {"gust", "A gust"},
      {"way", "A planned way, flown"},
      {"paths", "Ways through 1.6 million voxels"},
      {"instructions", "Instructions of a control step"}};
  for (const auto& heading : kHeadings) {
    if (group == heading[0]) return heading[1];
  }
  return group;
}

// JSON has no NaN: what breaks a line comes as null.
std::vector<double> numbers(const Json& list) {
  std::vector<double> out;
  for (const Json& value : list) out.push_back(value.is_number() ? value.get<double>() : std::nan(""));
  return out;
}

Series uav_series(const Json& curve, int colour) {
  Series line;
  line.name = curve.value("name", "");
  line.x = numbers(curve.value("x", Json::array()));
  line.y = numbers(curve.value("y", Json::array()));
  line.labels = curve.value("labels", std::vector<std::string>{});
  line.colour = colour;
  const std::string style = curve.value("style", "");
  line.dashed = style == "dashed";
  if (style == "dots") {
    line.mark = Mark::dots;
    line.width = 3.0;
  }
  if (style == "grey") {
    line.colour = kGrey;
    line.width = 1.0;
  }
  return line;
}

// Height of a picture with equal axes, from what it shows.
double fitting_height(const Plot& plot) {
  double low[2] = {1e300, 1e300};
  double high[2] = {-1e300, -1e300};
  for (const Series& line : plot.series) {
    for (int axis = 0; axis < 2; ++axis) {
      for (const double value : axis == 0 ? line.x : line.y) {
        if (!std::isfinite(value)) continue;
        low[axis] = std::min(low[axis], value);
        high[axis] = std::max(high[axis], value);
      }
    }
  }
  const double wide = high[0] - low[0];
  if (!(wide > 0.0)) return plot.height;
  return std::clamp(110.0 + (plot.width - 74.0) * 1.05 * (high[1] - low[1]) / wide, 200.0, 1400.0);
}

}  // namespace

Json run_uav_bench(const UavBenchOptions& options) {
  PeerProgram program{"sortie-bench-uav", options.program, {}, -1, options.passes};
  program.arguments = {"--seeds", std::to_string(options.seeds), "--fleet", std::to_string(options.fleet)};
  if (!options.only.empty()) program.arguments.insert(program.arguments.end(), {"--only", options.only});
  return run_peer_program(program);
}

std::vector<UavPicture> uav_pictures(const Json& result) {
  std::vector<UavPicture> pictures;
  for (const Json& wanted : result.value("pictures", Json::array())) {
    Plot plot;
    plot.title = wanted.value("title", "");
    plot.x.label = wanted.value("x", "");
    plot.x.log = wanted.value("log_x", false);
    plot.y.label = wanted.value("y", "");
    plot.y.log = wanted.value("log_y", false);
    plot.width = 860;
    plot.height = 440;
    int colour = 0;
    for (const Json& curve : wanted.value("curves", Json::array()))
      plot.series.push_back(uav_series(curve, colour++));
    plot.equal_aspect = wanted.value("equal", false);
    if (plot.equal_aspect) plot.height = fitting_height(plot);
    pictures.push_back({wanted.value("file", "") + ".svg", wanted.value("group", ""), std::move(plot)});
  }
  return pictures;
}

void print_uav_bench(std::ostream& out, const Json& result, bool colour) {
  for (const std::string& line : uav_conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string uav_bench_page(const Json& result, const std::string& command) {
  std::string text = "# The multirotor beside its peers\n\n";
  text += "Written by `" + command +
          "`. Flights are simulated and repeat exactly; run times are CPU time of one core and depend on the "
          "machine: **their ratios travel**. What flies: [flight](../uav.md), [its "
          "way](../uav-path.md).\n\n```\n";
  for (const std::string& line : uav_conditions(result)) text += line + "\n";
  text += "```\n";
  const std::vector<UavPicture> pictures = uav_pictures(result);
  std::vector<std::string> groups = figure_groups(result);
  for (const UavPicture& picture : pictures) {
    if (std::find(groups.begin(), groups.end(), picture.group) == groups.end())
      groups.push_back(picture.group);
  }
  for (const std::string& group : groups) {
    text += "\n## " + uav_heading(group) + "\n";
    for (const UavPicture& picture : pictures) {
      if (picture.group == group) text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
    }
    text += figures_page(result, group) + tables_page(result, group);
  }
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace sortie::firmware
