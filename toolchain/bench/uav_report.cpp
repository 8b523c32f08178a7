// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "toolchain/bench/peer_fronts.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> uav_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, std::to_string(settings.value("seeds", 0)) + " seeds, " +
                                    std::to_string(settings.value("fleet", 0)) + " drawn vehicles")};
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
std::vector<double> numbers(const firmware::Json& list) {
  std::vector<double> out;
  for (const firmware::Json& value : list)
    out.push_back(value.is_number() ? value.get<double>() : std::nan(""));
  return out;
}

Series uav_series(const firmware::Json& curve, int colour) {
  Series line;
  line.name = curve.value("name", "");
  line.x = numbers(curve.value("x", firmware::Json::array()));
  line.y = numbers(curve.value("y", firmware::Json::array()));
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

std::vector<BenchPicture> uav_pictures(const firmware::Json& result) {
  std::vector<BenchPicture> pictures;
  for (const firmware::Json& wanted : result.value("pictures", firmware::Json::array())) {
    Plot plot;
    plot.title = wanted.value("title", "");
    plot.x.label = wanted.value("x", "");
    plot.x.log = wanted.value("log_x", false);
    plot.y.label = wanted.value("y", "");
    plot.y.log = wanted.value("log_y", false);
    plot.width = 860;
    plot.height = 440;
    int colour = 0;
    for (const firmware::Json& curve : wanted.value("curves", firmware::Json::array()))
      plot.series.push_back(uav_series(curve, colour++));
    plot.equal_aspect = wanted.value("equal", false);
    if (plot.equal_aspect) plot.height = fitting_height(plot);
    pictures.push_back({wanted.value("file", "") + ".svg", std::move(plot), wanted.value("group", "")});
  }
  return pictures;
}

PeerFront uav_front() {
  PeerFront front;
  front.name = "uav";
  front.file = "bench-uav";
  front.about = "The multirotor beside its peers: flights, stress, error against run time, ways";
  front.footer =
      "Flights are simulated and repeat exactly; only run times depend on the machine. docs/uav.md tells "
      "what flies.\n"
      "Examples:\n"
      "  sortie bench uav --out out/uav\n"
      "  sortie bench uav --only stress --fleet 400\n"
      "  sortie bench uav --only rates --json";
  front.options = {
      {"--seeds", std::uint64_t{3}, "Seeds of noise, a flight each", 1, 1000},
      {"--fleet", std::uint64_t{40}, "Vehicles that are drawn", 1, 100000},
      choice("--only", "One part alone",
             {"peers", "stress", "estimated", "orders", "rates", "plant", "pictures", "paths", "count"})};
  front.title = "The multirotor beside its peers";
  front.intro =
      "Flights are simulated and repeat exactly; run times are CPU time of one core and depend on the "
      "machine: **their ratios travel**. What flies: [flight](../uav.md), [its way](../uav-path.md).";
  front.conditions = uav_conditions;
  front.heading = uav_heading;
  front.pictures = uav_pictures;
  return front;
}

}  // namespace sortie::toolchain
