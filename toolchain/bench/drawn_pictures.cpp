// SPDX-License-Identifier: BSD-3-Clause
// Pictures that a benchmark's program describes by itself: tests/bench/report/picture.hpp.
#include <algorithm>
#include <cmath>

#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

// JSON has no NaN: what breaks a line comes as null.
std::vector<double> numbers(const firmware::Json& list) {
  std::vector<double> out;
  for (const firmware::Json& value : list)
    out.push_back(value.is_number() ? value.get<double>() : std::nan(""));
  return out;
}

Series drawn_series(const firmware::Json& curve, int colour) {
  Series line;
  line.name = curve.value("name", "");
  line.x = numbers(curve.value("x", firmware::Json::array()));
  line.y = numbers(curve.value("y", firmware::Json::array()));
  line.labels = curve.value("labels", std::vector<std::string>{});
  line.colour = curve.value("colour", colour);
  const std::string style = curve.value("style", "");
  line.dashed = style == "dashed";
  if (style == "dots") {
    line.mark = Mark::dots;
    line.width = 3.0;
  }
  if (style == "default") {
    line.mark = Mark::dots;
    line.colour = kBlack;
    line.width = 5.0;
  }
  if (style == "grey") {
    line.colour = kGrey;
    line.width = 1.0;
  }
  return line;
}

// Height of a picture with equal axes, from what it shows.
double fitting_height(const Plot& plot) {
  Extent x;
  Extent y;
  for (const Series& line : plot.series) {
    x.take(line.x);
    y.take(line.y);
  }
  if (!(x.size() > 0.0)) return plot.height;
  return std::clamp(110.0 + (plot.width - 74.0) * 1.05 * y.size() / x.size(), 200.0, 1400.0);
}

}  // namespace

std::vector<BenchPicture> drawn_pictures(const firmware::Json& result) {
  std::vector<BenchPicture> pictures;
  for (const firmware::Json& wanted : result.value("pictures", firmware::Json::array())) {
    Plot plot{wanted.value("title", ""),
              {wanted.value("x", ""), wanted.value("log_x", false)},
              {wanted.value("y", ""), wanted.value("log_y", false)},
              860,
              440,
              wanted.value("equal", false)};
    int colour = 0;
    for (const firmware::Json& curve : wanted.value("curves", firmware::Json::array()))
      plot.series.push_back(drawn_series(curve, colour++));
    if (plot.equal_aspect) plot.height = fitting_height(plot);
    pictures.push_back({wanted.value("file", "") + ".svg", std::move(plot), wanted.value("group", "")});
  }
  return pictures;
}

}  // namespace sortie::toolchain
