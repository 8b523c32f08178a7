// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/report/front.hpp"

#include <algorithm>
#include <utility>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/judge/pareto.hpp"

namespace sortie::bench {

std::string decimals(double value, int count) { return firmware::format_fixed(value, count); }

void add_front(Report& report, Picture picture, std::vector<std::string> columns,
               const std::vector<FrontCell>& cells, FrontRows rows) {
  std::vector<toolchain::CostAndError> costs;
  for (const FrontCell& cell : cells) costs.push_back({cell.cost, cell.error});
  const std::vector<bool> front = toolchain::measured_front(std::move(costs));
  columns.emplace_back("");
  Json table = Json::array();
  Curve defaults;
  defaults.style = "default";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const FrontCell& cell = cells[i];
    std::string mark = front[i] ? "front" : "";
    if (cell.by_itself) mark += mark.empty() ? "defaults" : ", defaults";
    if (rows == FrontRows::all || !mark.empty()) {
      Json row = cell.row;
      row.push_back(mark);
      table.push_back(row);
    }
    Curve* curve = &defaults;
    if (!cell.by_itself) {
      auto found = std::find_if(picture.curves.begin(), picture.curves.end(),
                                [&cell](const Curve& c) { return c.name == cell.curve; });
      if (found == picture.curves.end()) {
        Curve fresh;
        fresh.name = cell.curve;
        fresh.style = "dots";
        found = picture.curves.insert(found, fresh);
      }
      curve = &*found;
    }
    curve->x.push_back(cell.cost);
    curve->y.push_back(cell.error);
    curve->labels.push_back(cell.by_itself ? "defaults" : front[i] ? cell.label : "");
  }
  if (!defaults.x.empty()) picture.curves.push_back(defaults);
  report.add_table(picture.group, columns, table);
  add_picture(report, picture);
}

}  // namespace sortie::bench
