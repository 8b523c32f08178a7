// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

// What sets a cell apart from the defaults.
std::string mapping_cell_name(const firmware::Json& row) {
  const std::string knob = row.value("knob", "");
  if (knob == "voxel") return firmware::format_short(row.value("voxel_m", 0.0)) + " m";
  if (knob == "points") return firmware::format_short(row.value("min_points", 0.0)) + " points";
  if (knob == "units") return firmware::format_short(row.value("units", 0.0)) + " units";
  if (knob == "solves") return firmware::format_short(row.value("solves", 0.0)) + " solves";
  if (knob == "restate") return "restate " + firmware::format_short(row.value("restate_m", 0.0)) + " m";
  return "";
}

Plot mapping_error_over_time(const firmware::Json& sweep, const std::string& stream) {
  Plot plot{"Segments: error over run time, " + stream,
            {"run time of a step, median, ms", true},
            {"error: 1 - agreement x share shown"},
            860,
            460};
  int colour = 0;
  for (const char* policy : {"Euclidean", "smoothness"}) {
    Series cells{policy, Mark::dots, colour, 3};
    Series front{std::string(policy) + ", front", Mark::line, colour, 1, true};
    Series defaults{"", Mark::dots, kBlack, 5};
    std::vector<std::pair<double, double>> on_front;
    for (const firmware::Json& row : sweep) {
      if (row.value("stream", "") != stream || row.value("policy", "") != policy) continue;
      if (!row["error"].is_number()) continue;
      const double ms = row.value("p50_ms", 0.0);
      const double error = row.value("error", 0.0);
      if (row.value("front", false)) on_front.emplace_back(ms, error);
      const bool is_default = row.value("knob", "") == "defaults";
      Series& series = is_default ? defaults : cells;
      series.add(ms, error);
      series.labels.push_back(is_default ? "defaults" : mapping_cell_name(row));
    }
    std::sort(on_front.begin(), on_front.end());
    for (const auto& [ms, error] : on_front) front.add(ms, error);
    for (Series* series : {&front, &cells, &defaults}) plot.series.push_back(std::move(*series));
    ++colour;
  }
  return plot;
}

// The largest segments by colour, all others in grey.
Plot map_seen_from_above(const firmware::Json& picture) {
  const auto x = picture.value("x", std::vector<double>{});
  const auto y = picture.value("y", std::vector<double>{});
  const auto segment = picture.value("segment", std::vector<std::uint32_t>{});
  std::map<std::uint32_t, std::size_t> sizes;
  for (const std::uint32_t id : segment) ++sizes[id];
  std::vector<std::pair<std::size_t, std::uint32_t>> order;
  for (const auto& [id, size] : sizes) order.emplace_back(size, id);
  std::sort(order.rbegin(), order.rend());
  Plot plot{"Segments half a metre about the sensor's height, from above: " + picture.value("stream", "") +
                ", " + picture.value("policy", ""),
            {"x, m"},
            {"y, m"},
            820,
            640,
            true};
  constexpr std::size_t kColours = 7;  // neighbours by size take turns
  constexpr std::size_t kShown = 140;
  std::map<std::uint32_t, int> colour_of;
  for (std::size_t i = 0; i < std::min(order.size(), kShown); ++i)
    colour_of[order[i].second] = static_cast<int>(i % kColours);
  std::vector<Series> by_colour(kColours + 1);
  for (std::size_t i = 0; i < segment.size(); ++i) {
    const auto found = colour_of.find(segment[i]);
    Series& series = by_colour[found == colour_of.end() ? kColours : static_cast<std::size_t>(found->second)];
    series.add(x[i], y[i]);
  }
  for (std::size_t i = 0; i < by_colour.size(); ++i) {
    by_colour[i].mark = Mark::dots;
    by_colour[i].colour = static_cast<int>(i);
    by_colour[i].width = 1.1;
    if (!by_colour[i].x.empty()) plot.series.push_back(std::move(by_colour[i]));
  }
  return plot;
}

}  // namespace

std::vector<BenchPicture> mapping_pictures(const firmware::Json& result) {
  std::vector<BenchPicture> pictures;
  const firmware::Json sweep = result.value("sweep", firmware::Json::array());
  std::vector<std::string> streams;
  for (const firmware::Json& row : sweep) {
    const std::string stream = row.value("stream", "");
    if (std::find(streams.begin(), streams.end(), stream) == streams.end()) streams.push_back(stream);
  }
  for (const std::string& stream : streams)
    pictures.push_back({"bench-local-map-" + stream + ".svg", mapping_error_over_time(sweep, stream), ""});
  for (const firmware::Json& picture : result.value("pictures", firmware::Json::array())) {
    if (picture.value("policy", "") != "smoothness" || picture.value("stream", "") == "dense") continue;
    pictures.push_back({"bench-local-map-" + picture.value("stream", "") + "-segments.svg",
                        map_seen_from_above(picture), ""});
  }
  return pictures;
}

}  // namespace sortie::toolchain
