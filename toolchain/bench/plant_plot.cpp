// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <numeric>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

constexpr const char* kStepFile = "bench-plant-step.svg";
// Below this an error is rounding on a plane: it would only stretch the axis.
constexpr double kLeastError_mm = 1e-3;

Plot plot_steps(const firmware::Json& curves) {
  Plot plot{"Error over run time, by step size",
            {"run time, \u00b5s per simulated second", true},
            {"mean distance to the reference, mm", true},
            820,
            460};
  std::vector<Series>& lines = plot.series;
  for (const firmware::Json& point : curves) {
    const std::string name = point.value("kind", "") + ": " + point.value("way", "");
    auto line = std::find_if(lines.begin(), lines.end(), [&](const Series& one) { return one.name == name; });
    if (line == lines.end()) {
      line = lines.insert(lines.end(), {name, Mark::line, static_cast<int>(lines.size())});
      line->dashed = point.value("kind", "") == "closed form";
    }
    line->add(point.value("us_per_s", 0.0), std::max(point.value("error_mm", 0.0), kLeastError_mm));
    line->labels.push_back(
        point.value("named", false) ? firmware::format_short(point.value("dt_ms", 0.0)) + " ms" : "");
  }
  return plot;
}

Series outline(const firmware::Json& shape, int colour, double width) {
  const std::vector<double> none;
  return {"", Mark::line, colour, width, false, shape.value("x", none), shape.value("z", none)};
}

// What the outlines and the ground reach.
struct Reach {
  Extent x;
  Extent z{0.0, 0.0};
};

// A moment's time in the middle of its track.
Series time_label(const firmware::Json& moment, const Series& track) {
  const auto count = static_cast<double>(track.x.size());
  Series label{"", Mark::dots, track.colour, 0.1};
  label.add(std::accumulate(track.x.begin(), track.x.end(), 0.0) / count,
            std::accumulate(track.y.begin(), track.y.end(), 0.0) / count);
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
      reach.x.take(line.x);
      reach.z.take(line.y);
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
  Series contacts{"loaded contacts", Mark::dots, kVermilion, 2.2};
  for (const firmware::Json& moment : moments) {
    const firmware::Json points = moment.value("contacts", firmware::Json::object());
    for (const double x : points.value("x", std::vector<double>{})) contacts.x.push_back(x);
    for (const double z : points.value("z", std::vector<double>{})) contacts.y.push_back(z);
  }
  return contacts;
}

Plot side_view(const firmware::Json& picture) {
  Plot plot{picture.value("scene", "") + ": " + picture.value("about", "") + ", friction " +
                firmware::format_short(picture.value("friction", 0.0)) + ", contact surface motion",
            {"x, m"},
            {"z, m"},
            1000,
            320,
            true};
  for (const firmware::Json& solid : picture.value("solids", firmware::Json::array()))
    plot.series.push_back(outline(solid, kGrey, 1.2));
  if (!plot.series.empty()) plot.series.front().name = "obstacles";
  const firmware::Json moments = picture.value("moments", firmware::Json::array());
  const Reach reach = draw_moments(moments, plot.series);
  plot.series.push_back(loaded_contacts(moments));
  if (reach.x.low < reach.x.high) {
    plot.x.low = reach.x.low - 0.1;
    plot.x.high = reach.x.high + 0.1;
    plot.y.low = -0.05;
    plot.y.high = reach.z.high + 0.1;
    plot.height = 110 + (plot.width - 74) * (reach.z.high + 0.15) / (reach.x.high - reach.x.low + 0.2);
    plot.series.insert(plot.series.begin(),
                       {"", Mark::line, kBlack, 1.6, false, {plot.x.low, plot.x.high}, {0, 0}});
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
