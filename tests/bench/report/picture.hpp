// SPDX-License-Identifier: BSD-3-Clause
// Pictures for the report: curves with their axes, as JSON that `sortie bench` draws.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/report/figures.hpp"

namespace sortie::bench {

/// One line of a picture.
struct Curve {  // NOLINT(bugprone-exception-escape): vectors' own moves
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
  std::vector<std::string> labels;  ///< beside each point; empty: none
  std::string style;                ///< "", "dashed", "dots", "grey", or "default": black dots
  int colour{-1};                   ///< its number; -1: the next one
};

/// A picture in `file` (without ending), belonging to a group of figures.
struct Picture {  // NOLINT(bugprone-exception-escape)
  std::string file;
  std::string group;
  std::string title;
  std::string x;
  std::string y;
  bool log_x{};
  bool log_y{};
  bool equal{};  ///< a metre is as long on both axes
  std::vector<Curve> curves;
};

inline void add_picture(Report& report, const Picture& picture) {
  Json curves = Json::array();
  for (const Curve& curve : picture.curves) {
    Json line = {{"name", curve.name}, {"x", curve.x}, {"y", curve.y}, {"style", curve.style}};
    if (!curve.labels.empty()) line["labels"] = curve.labels;
    if (curve.colour >= 0) line["colour"] = curve.colour;
    curves.push_back(line);
  }
  report.root()["pictures"].push_back({{"file", picture.file},
                                       {"group", picture.group},
                                       {"title", picture.title},
                                       {"x", picture.x},
                                       {"y", picture.y},
                                       {"log_x", picture.log_x},
                                       {"log_y", picture.log_y},
                                       {"equal", picture.equal},
                                       {"curves", curves}});
}

}  // namespace sortie::bench
