// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numeric>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_fronts.hpp"

namespace sortie::toolchain {

namespace {

constexpr const char* kStepFile = "bench-plant-step.svg";
// Below this an error is rounding on a plane: it would only stretch the axis.
constexpr double kLeastError_mm = 1e-3;

struct Curve {
  std::string name;
  Series line;
};

Plot plot_steps(const firmware::Json& curves) {
  std::vector<Curve> found;
  for (const firmware::Json& point : curves) {
    const std::string name = point.value("kind", "") + ": " + point.value("way", "");
    auto curve = std::find_if(found.begin(), found.end(), [&](const Curve& c) { return c.name == name; });
    if (curve == found.end()) {
      curve = found.insert(found.end(), Curve{name, {}});
      const int number = static_cast<int>(found.size()) - 1;
      curve->line.name = name;
      curve->line.colour = number;
      curve->line.dashed = point.value("kind", "") == "closed form";
    }
    Series& line = curve->line;
    line.x.push_back(point.value("us_per_s", 0.0));
    line.y.push_back(std::max(point.value("error_mm", 0.0), kLeastError_mm));
    line.labels.push_back(
        point.value("named", false) ? firmware::format_short(point.value("dt_ms", 0.0)) + " ms" : "");
  }
  Plot plot;
  plot.title = "Error over run time, by step size";
  plot.x = {"run time, \u00b5s per simulated second", true};
  plot.y = {"mean distance to the reference, mm", true};
  plot.width = 820;
  plot.height = 460;
  for (Curve& curve : found) plot.series.push_back(std::move(curve.line));
  return plot;
}

Series outline(const firmware::Json& shape, int colour, double width) {
  Series line;
  line.x = shape.value("x", std::vector<double>{});
  line.y = shape.value("z", std::vector<double>{});
  line.colour = colour;
  line.width = width;
  return line;
}

// What the outlines reach.
struct Reach {
  double low{1e9};
  double high{-1e9};
  double top{};

  void take(const Series& line) {
    low = std::min(low, *std::min_element(line.x.begin(), line.x.end()));
    high = std::max(high, *std::max_element(line.x.begin(), line.x.end()));
    top = std::max(top, *std::max_element(line.y.begin(), line.y.end()));
  }
};

// A moment's time in the middle of its track.
Series time_label(const firmware::Json& moment, const Series& track) {
  const auto count = static_cast<double>(track.x.size());
  Series label;
  label.mark = Mark::dots;
  label.colour = track.colour;
  label.width = 0.1;
  label.x = {std::accumulate(track.x.begin(), track.x.end(), 0.0) / count};
  label.y = {std::accumulate(track.y.begin(), track.y.end(), 0.0) / count};
  label.labels = {firmware::format_fixed(moment.value("t_s", 0.0), 1) + " s"};
  return label;
}

// The vehicle at the moments; neighbours in time overlap: they take turns between two colours.
Reach draw_moments(const firmware::Json& moments, std::vector<Series>& series) {
  Reach reach;
  int number = 0;
  for (const firmware::Json& moment : moments) {
    const int colour = number++ % 2 == 0 ? kBlue : kGreen;
    bool first = true;
    for (const firmware::Json& shape : moment.value("outlines", firmware::Json::array())) {
      Series line = outline(shape, colour, 1.4);
      if (line.x.empty()) continue;
      reach.take(line);
      if (first) {
        if (number <= 2) line.name = number == 1 ? "track and flippers" : "the next moment";
        series.push_back(time_label(moment, line));
      }
      first = false;
      series.push_back(std::move(line));
    }
  }
  return reach;
}

Series loaded_contacts(const firmware::Json& moments) {
  Series contacts;
  contacts.name = "loaded contacts";
  contacts.mark = Mark::dots;
  contacts.colour = kVermilion;
  contacts.width = 2.2;
  for (const firmware::Json& moment : moments) {
    const firmware::Json points = moment.value("contacts", firmware::Json::object());
    for (const double x : points.value("x", std::vector<double>{})) contacts.x.push_back(x);
    for (const double z : points.value("z", std::vector<double>{})) contacts.y.push_back(z);
  }
  return contacts;
}

Plot side_view(const firmware::Json& picture) {
  Plot plot;
  plot.title = picture.value("scene", "") + ": " + picture.value("about", "") + ", friction " +
               firmware::format_short(picture.value("friction", 0.0)) + ", contact surface motion";
  plot.x = {"x, m"};
  plot.y = {"z, m"};
  plot.equal_aspect = true;
  plot.width = 1000;
  for (const firmware::Json& solid : picture.value("solids", firmware::Json::array()))
    plot.series.push_back(outline(solid, kGrey, 1.2));
  if (!plot.series.empty()) plot.series.front().name = "obstacles";
  const firmware::Json moments = picture.value("moments", firmware::Json::array());
  const Reach reach = draw_moments(moments, plot.series);
  plot.series.push_back(loaded_contacts(moments));
  if (reach.low < reach.high) {
    plot.x.low = reach.low - 0.1;
    plot.x.high = reach.high + 0.1;
    plot.y.low = -0.05;
    plot.y.high = reach.top + 0.1;
    plot.height = 110 + (plot.width - 74) * (reach.top + 0.15) / (reach.high - reach.low + 0.2);
    Series ground;
    ground.x = {plot.x.low, plot.x.high};
    ground.y = {0, 0};
    ground.colour = kBlack;
    plot.series.insert(plot.series.begin(), std::move(ground));
  }
  return plot;
}

}  // namespace

std::vector<BenchPicture> plant_pictures(const firmware::Json& result) {
  std::vector<BenchPicture> pictures;
  if (const firmware::Json curves = result.value("step_curves", firmware::Json::array()); !curves.empty())
    pictures.push_back({kStepFile, plot_steps(curves), "step size"});
  for (const firmware::Json& picture : result.value("pictures", firmware::Json::array()))
    pictures.push_back(
        {"bench-plant-" + picture.value("scene", "") + ".svg", side_view(picture), "Side views"});
  return pictures;
}

}  // namespace sortie::toolchain
