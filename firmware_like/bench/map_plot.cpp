// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "firmware_like/bench/map_bench.hpp"

namespace sortie::firmware {

namespace {

constexpr double kLeastError = 1e-4;  // below this a log axis would only stretch

Plot plot_rows(const std::string& group, const std::vector<nlohmann::ordered_json>& rows) {
  Plot plot;
  plot.title = group;
  plot.x = {"run time of a step (median), ms", true};
  plot.y = {rows.front().value("judged", "") == "truth" ? "1 - agreement with the true faces x held"
                                                        : "1 - agreement with the finest voxels x held",
            true};
  plot.width = 820;
  plot.height = 420;
  std::map<std::string, Series> knobs;
  std::vector<std::string> order;
  Series own;
  own.name = "profile";
  own.mark = Mark::dots;
  own.colour = kVermilion;
  own.width = 7;
  for (const nlohmann::ordered_json& row : rows) {
    const std::string knob = row.value("knob", "");
    const double ms = row.value("p50_ms", 0.0);
    const double error = std::max(row.value("error", 1.0), kLeastError);
    if (knob == "profile") {
      own.x = {ms};
      own.y = {error};
      continue;
    }
    if (knobs.find(knob) == knobs.end()) order.push_back(knob);
    Series& series = knobs[knob];
    series.x.push_back(ms);
    series.y.push_back(error);
    series.labels.push_back(row.value("value", ""));
  }
  int colour = 0;
  for (const std::string& knob : order) {
    Series& series = knobs[knob];
    series.name = knob;
    series.mark = Mark::dots;
    series.width = 4.5;
    while (colour == kVermilion) ++colour;
    series.colour = colour++;
    plot.series.push_back(series);
  }
  plot.series.push_back(own);
  return plot;
}

}  // namespace

std::vector<MapPicture> map_pictures(const nlohmann::ordered_json& result) {
  std::vector<MapPicture> pictures;
  std::vector<nlohmann::ordered_json> rows;
  const auto flush = [&] {
    if (rows.empty()) return;
    pictures.push_back({"bench-mapping-" + std::to_string(pictures.size() + 1) + ".svg",
                        plot_rows(rows.front().value("group", ""), rows)});
    rows.clear();
  };
  for (const nlohmann::ordered_json& row : result.value("map_rows", nlohmann::ordered_json::array())) {
    if (!rows.empty() && rows.front().value("group", "") != row.value("group", "")) flush();
    rows.push_back(row);
  }
  flush();
  return pictures;
}

}  // namespace sortie::firmware
