// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <ostream>

#include "firmware_like/bench/figure_passes.hpp"
#include "firmware_like/bench/figure_table.hpp"
#include "firmware_like/bench/mapping_bench.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

std::vector<std::string> mapping_conditions(const Json& result) {
  std::vector<std::string> lines;
  lines.push_back("machine   " + result.value("machine", "") + "; " + result.value("compiler", ""));
  const Json settings = result.value("settings", Json::object());
  lines.push_back("settings  every " + std::to_string(settings.value("stride", 0)) +
                  ". point, PCL at every " + std::to_string(settings.value("every", 0)) +
                  ". scan, load average " + result.value("load_before", "?") + " before, " +
                  result.value("load_after", "?") + " after" + passes_words(result));
  if (result.contains("doctor")) lines.push_back("doctor    " + result["doctor"].value("summary", ""));
  return lines;
}

// Every figure that has a goal, in one group.
Json mapping_goals(const Json& result) {
  Json goals;
  goals["figures"] = Json::array();
  for (Json figure : result.value("figures", Json::array())) {
    if (figure.value("goal", "").empty()) continue;
    figure["what"] = figure.value("group", "") + ": " + figure.value("what", "");
    figure["group"] = "goals";
    goals["figures"].push_back(figure);
  }
  return goals;
}

std::string mapping_figure_text(const Json& value) {
  return value.is_number() ? format_short(value.get<double>()) : "";
}

// The cells of one stream and policy as a table of the usual form.
Json mapping_sweep_tables(const Json& result) {
  Json all;
  all["tables"] = Json::array();
  for (const Json& row : result.value("sweep", Json::array())) {
    const std::string group = row.value("stream", "") + ", " + row.value("policy", "");
    const bool smooth = row.value("policy", "") == "smoothness";
    if (all["tables"].empty() || all["tables"].back().value("group", "") != group) {
      Json columns = {"voxel m", "points", "units",  "error",  "agreement", "missed", "own batch",
                      "p50 ms",  "p99 ms", "max ms", "voxels", "B a voxel", "MB",     "waiting"};
      if (smooth) {
        for (const char* name : {"solves", "restate m", "normal p50 deg", "normal p95 deg"})
          columns.push_back(name);
      }
      columns.push_back("");
      all["tables"].push_back({{"group", group}, {"columns", columns}, {"rows", Json::array()}});
    }
    const auto limit = [&row](const char* key) {
      const double value = row.value(key, 0.0);
      return value > 0 ? format_short(value) : std::string("all");
    };
    Json line = {row["voxel_m"], row["min_points"],    limit("units"), row["error"],         row["agreement"],
                 row["missed"],  row["own_agreement"], row["p50_ms"],  row["p99_ms"],        row["max_ms"],
                 row["voxels"],  row["bytes_a_voxel"], row["mb"],      row["waiting_blocks"]};
    if (smooth) {
      line.push_back(limit("solves"));
      for (const char* key : {"restate_m", "normal_deg", "normal_p95_deg"})
        line.push_back(mapping_figure_text(row.value(key, Json())));
    }
    std::string mark = row.value("front", false) ? "front" : "";
    if (row.value("knob", "") == "defaults") mark += mark.empty() ? "defaults" : ", defaults";
    line.push_back(mark);
    all["tables"].back()["rows"].push_back(line);
  }
  return all;
}

constexpr const char* kMappingSweepWords =
    "*agreement*: adjusted Rand index against a batch in double over all points of the stream in voxels of "
    "0.05 m, looked up at every eleventh of these voxels; *missed*: share of them that the map shows no "
    "segment at, be it not held, not active or in the backlog; *error* = 1 - agreement x (1 - missed). *own "
    "batch*: the same index against a batch over the map's own means. *waiting*: blocks in the backlogs, "
    "median. Angles are those of flat voxels to the fine batch's normals. *front*: no other cell is as cheap "
    "(within 5 %) and better (by 0.1 %). *defaults*: what the map does unasked. Growing radius 0.2 m and "
    "normals 0.3 m, from voxels of 0.15 m on 1.5 and 2 voxels; local map 15 m. Two cores that others use: "
    "p99 and max hold what they took.";

}  // namespace

void print_mapping_bench(std::ostream& out, const Json& result, bool colour) {
  for (const std::string& line : mapping_conditions(result)) out << line << "\n";
  print_figures(out, mapping_goals(result), "goals", colour);
  for (const std::string& group : figure_groups(result)) {
    if (group == "bounds") continue;
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  const Json sweep = mapping_sweep_tables(result);
  for (const std::string& group : figure_groups(sweep)) {
    out << "\n" << group << "\n";
    print_tables(out, sweep, group);
  }
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string mapping_bench_page(const Json& result, const std::string& command) {
  std::string text = "# The local map beside PCL, and its error over run time\n\n";
  text += "Written by `" + command +
          "`. Times are of the thread's processor, medians; **the ratios travel, absolute times do not**. "
          "The map takes scan after scan, PCL starts anew from the map's voxels. What it is: "
          "[the local map](../mapping.md).\n\n```\n";
  for (const std::string& line : mapping_conditions(result)) text += line + "\n";
  text += "```\n\n## All goals\n" + figures_page(mapping_goals(result), "goals");
  for (const std::string& group : figure_groups(result)) {
    if (group == "bounds") continue;
    text += "\n## " + group + "\n" + figures_page(result, group) + tables_page(result, group);
  }
  const Json sweep = mapping_sweep_tables(result);
  if (!sweep["tables"].empty())
    text += std::string("\n## Error over run time\n\n") + kMappingSweepWords + "\n";
  for (const MappingPicture& picture : mapping_pictures(result))
    text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
  for (const std::string& group : figure_groups(sweep))
    text += "\n### " + group + "\n" + tables_page(sweep, group);
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace sortie::firmware
