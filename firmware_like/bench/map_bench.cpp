// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/bench/map_bench.hpp"

#include <limits>
#include <ostream>

#include "firmware_like/bench/figure_table.hpp"
#include "firmware_like/bench/pareto.hpp"
#include "firmware_like/bench/peer_program.hpp"

namespace sortie::firmware {

namespace {

using MapJson = nlohmann::ordered_json;

constexpr double kCloseTimes = 0.05;  // a smaller difference is the machine's
constexpr double kCloseErrors = 0.01;

std::vector<std::string> map_conditions(const MapJson& result) {
  const MapJson settings = result.value("settings", MapJson::object());
  return {"machine   " + result.value("machine", "") + "; " + result.value("compiler", ""),
          "settings  point 1 of " + std::to_string(settings.value("stride", 0)) + ", PCL at scan 1 of " +
              std::to_string(settings.value("every", 0)) + ", hall of seed " +
              std::to_string(settings.value("seed", 0)) + ", load average " +
              result.value("load_before", "?") + " before, " + result.value("load_after", "?") + " after"};
}

/// What a figure is called in a row and in the table.
struct RowColumn {
  const char* key;
  const char* name;
};
constexpr RowColumn kRowColumns[] = {{"knob", "knob"},
                                     {"value", "value"},
                                     {"n", "n"},
                                     {"p50_ms", "p50 ms"},
                                     {"p99_ms", "p99 ms"},
                                     {"max_ms", "max ms"},
                                     {"kB", "kB"},
                                     {"batch", "as batch"},
                                     {"finest", "as finest"},
                                     {"truth", "as faces"},
                                     {"held", "held"},
                                     {"backlog", "backlog"},
                                     {"normal_p50_deg", "normal p50 deg"},
                                     {"normal_p95_deg", "normal p95 deg"}};

// The tables are those of the rows, one a group; columns that nothing fills are left out.
void add_row_tables(MapJson& result) {
  MapJson groups = MapJson::object();
  for (const MapJson& row : result["map_rows"]) groups[row.value("group", "")].push_back(row);
  for (const auto& [group, rows] : groups.items()) {
    MapJson table{{"group", group}, {"columns", MapJson::array()}, {"rows", MapJson::array()}};
    std::vector<const char*> keys;
    for (const RowColumn& column : kRowColumns) {
      bool filled = false;
      for (const MapJson& row : rows)
        filled = filled || !row[column.key].is_string() || row[column.key] != "";
      if (!filled) continue;
      keys.push_back(column.key);
      table["columns"].push_back(column.name);
    }
    table["columns"].push_back("");
    for (const MapJson& row : rows) {
      MapJson cells = MapJson::array();
      for (const char* key : keys) cells.push_back(row[key]);
      std::string mark = row.value("front", false) ? "front" : "";
      if (row.value("knob", "") == "profile") mark += mark.empty() ? "profile" : ", profile";
      if (row.value("pool_full", 0) > 0) mark += mark.empty() ? "pool full" : ", pool full";
      cells.push_back(mark);
      table["rows"].push_back(cells);
    }
    result["tables"].push_back(table);
  }
}

}  // namespace

void mark_map_rows(MapJson& result) {
  MapJson& rows = result["map_rows"];
  for (std::size_t begin = 0; begin < rows.size();) {
    std::size_t end = begin;
    while (end < rows.size() && rows[end].value("group", "") == rows[begin].value("group", "")) ++end;
    std::vector<CostAndError> points;
    for (std::size_t i = begin; i < end; ++i) {
      MapJson& row = rows[i];
      const char* judged =
          row["truth"].is_number() && !row["normal_p50_deg"].is_string() ? "truth" : "finest";
      row["judged"] = judged;
      row["error"] = 1.0 - row.value(judged, 0.0) * row.value("held", 0.0);
      points.push_back(
          {row.value("p50_ms", std::numeric_limits<double>::quiet_NaN()), row["error"].get<double>()});
    }
    merge_close(points, &CostAndError::cost, kCloseTimes);
    merge_close(points, &CostAndError::error, kCloseErrors);
    const std::vector<bool> front = pareto_front(points);
    for (std::size_t i = begin; i < end; ++i) rows[i]["front"] = static_cast<bool>(front[i - begin]);
    begin = end;
  }
}

MapJson run_map_bench(const MapBenchOptions& options) {
  PeerProgram program{"sortie-bench-mapping", options.program, {}, -1};
  program.arguments = {"--every", std::to_string(options.every), "--seed", std::to_string(options.seed)};
  const auto also = [&program](const std::string& option, const std::string& value) {
    program.arguments.insert(program.arguments.end(), {option, value});
  };
  if (!options.log.empty()) also("--file", options.log);
  if (options.count) also("--count", "yes");
  if (!options.only.empty()) also("--only", options.only);
  MapJson result = run_peer_program(program);
  if (!result.contains("map_rows")) result["map_rows"] = MapJson::array();
  mark_map_rows(result);
  add_row_tables(result);
  return result;
}

void print_map_bench(std::ostream& out, const MapJson& result, bool colour) {
  for (const std::string& line : map_conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  for (const std::string& skip : figure_skips(result)) out << "skipped: " << skip << "\n";
  out << "\n";
}

std::string map_bench_page(const MapJson& result, const std::string& command) {
  std::string text = "# The local map: beside PCL, and error against run time\n\n";
  text +=
      "Written by `" + command +
      "`. Thread processor time of a step (a scan, all the way to segments): **ratios travel, absolute times "
      "do "
      "not**. What the parts are: [the local map](../mapping.md).\n\n"
      "One knob at a time differs from the profile's settings (voxel 0.1 m, 1 point, no budget; growing "
      "radius 2 "
      "voxels, normals over 3). Partitions are compared by the adjusted Rand index: 1 is the same, 0 what "
      "chance "
      "gives.\n\n"
      "- **as batch**: with a batch in double over the same voxels at that moment. Without a budget it is 1 "
      "for Euclidean segments; for smoothness it holds the coarse copy of normals and what `restate_m` "
      "left as it was. With a budget it falls as segments lag behind.\n"
      "- **as finest**: with the batch over the finest voxels of the sweep, point by point of the newest "
      "scan.\n"
      "- **as faces**: with the true faces of the simulated hall, point by point. A floor joins all that "
      "stands on "
      "it: of Euclidean segments nothing else can be expected.\n"
      "- **held**: share of the newest scan's points that lie in an active voxel.\n"
      "- **backlog**: blocks that wait after a step, on average.\n"
      "- **normal**: angle to a batch in double over the current means, of voxels where the normal is well "
      "defined.\n"
      "- **front**: nothing else in the table is as cheap (within 5 %) and better (by 1 %), error being 1 - "
      "agreement x held, with agreement as the picture's axis says.\n\n```\n";
  for (const std::string& line : map_conditions(result)) text += line + "\n";
  text += "```\n";
  for (const std::string& skip : figure_skips(result)) text += "\nskipped: " + skip + "\n";
  const std::vector<MapPicture> pictures = map_pictures(result);
  for (const std::string& group : figure_groups(result)) {
    text += "\n## " + group + "\n" + figures_page(result, group) + tables_page(result, group);
    for (const MapPicture& picture : pictures) {
      if (picture.plot.title == group) text += "\n![" + group + "](" + picture.file + ")\n";
    }
  }
  return text;
}

}  // namespace sortie::firmware
