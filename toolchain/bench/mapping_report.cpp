// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <map>
#include <ostream>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/figure_table.hpp"
#include "toolchain/bench/peer_front.hpp"
#include "toolchain/judge/pareto.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> mapping_settings(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {settings_line(result, "every " + std::to_string(settings.value("stride", 0)) +
                                    ". point, PCL at every " + std::to_string(settings.value("every", 0)) +
                                    ". scan")};
}

double mapping_number(const firmware::Json& row, const char* key) {
  const auto found = row.find(key);
  return found != row.end() && found->is_number() ? found->get<double>()
                                                  : std::numeric_limits<double>::quiet_NaN();
}

// Marks the cells of the sweep that no other beats: each stream and policy has its front.
void mark_mapping_fronts(firmware::Json& result) {
  if (!result.contains("sweep")) return;
  firmware::Json& sweep = result["sweep"];
  std::map<std::string, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < sweep.size(); ++i) {
    firmware::Json& row = sweep[i];
    row["error"] = 1.0 - mapping_number(row, "agreement") * (1.0 - mapping_number(row, "missed"));
    groups[row.value("stream", "") + row.value("policy", "")].push_back(i);
  }
  for (const auto& [name, members] : groups) {
    std::vector<CostAndError> points;
    for (const std::size_t i : members)
      points.push_back({mapping_number(sweep[i], "p50_ms"), mapping_number(sweep[i], "error")});
    const std::vector<bool> front = measured_front(std::move(points));
    for (std::size_t i = 0; i < members.size(); ++i) sweep[members[i]]["front"] = bool{front[i]};
  }
}

// Every figure that has a goal, in one group.
firmware::Json mapping_goals(const firmware::Json& result) {
  firmware::Json goals;
  goals["figures"] = firmware::Json::array();
  for (firmware::Json figure : result.value("figures", firmware::Json::array())) {
    if (figure.value("goal", "").empty()) continue;
    figure["what"] = figure.value("group", "") + ": " + figure.value("what", "");
    figure["group"] = "goals";
    goals["figures"].push_back(figure);
  }
  return goals;
}

std::string mapping_figure_text(const firmware::Json& value) {
  return value.is_number() ? firmware::format_short(value.get<double>()) : "";
}

// The cells of one stream and policy as a table of the usual form.
firmware::Json mapping_sweep_tables(const firmware::Json& result) {
  firmware::Json all;
  all["tables"] = firmware::Json::array();
  for (const firmware::Json& row : result.value("sweep", firmware::Json::array())) {
    const std::string group = row.value("stream", "") + ", " + row.value("policy", "");
    const bool smooth = row.value("policy", "") == "smoothness";
    if (all["tables"].empty() || all["tables"].back().value("group", "") != group) {
      firmware::Json columns = {"voxel m", "points", "units",  "error",  "agreement", "missed", "own batch",
                                "p50 ms",  "p99 ms", "max ms", "voxels", "B a voxel", "MB",     "waiting"};
      if (smooth) {
        for (const char* name : {"solves", "restate m", "normal p50 deg", "normal p95 deg"})
          columns.push_back(name);
      }
      columns.push_back("");
      all["tables"].push_back({{"group", group}, {"columns", columns}, {"rows", firmware::Json::array()}});
    }
    const auto limit = [&row](const char* key) {
      const double value = row.value(key, 0.0);
      return value > 0 ? firmware::format_short(value) : std::string("all");
    };
    firmware::Json line = {row["voxel_m"],   row["min_points"],    limit("units"),       row["error"],
                           row["agreement"], row["missed"],        row["own_agreement"], row["p50_ms"],
                           row["p99_ms"],    row["max_ms"],        row["voxels"],        row["bytes_a_voxel"],
                           row["mb"],        row["waiting_blocks"]};
    if (smooth) {
      line.push_back(limit("solves"));
      for (const char* key : {"restate_m", "normal_deg", "normal_p95_deg"})
        line.push_back(mapping_figure_text(row.value(key, firmware::Json())));
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

void print_mapping(std::ostream& out, const firmware::Json& result, bool colour) {
  for (const std::string& line : bench_conditions(mapping_front(), result)) out << line << "\n";
  print_figures(out, mapping_goals(result), "goals", colour);
  for (const std::string& group : figure_groups(result)) {
    if (group == "bounds") continue;
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  const firmware::Json sweep = mapping_sweep_tables(result);
  for (const std::string& group : figure_groups(sweep)) {
    out << "\n" << group << "\n";
    print_tables(out, sweep, group);
  }
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string mapping_page(const firmware::Json& result, const std::string& command) {
  std::string text = "# The local map beside PCL, and its error over run time\n\n";
  text += "Written by `" + command +
          "`. Times are of the thread's processor, medians; **the ratios travel, absolute times do not**. "
          "The map takes scan after scan, PCL starts anew from the map's voxels. What it is: "
          "[the local map](../mapping.md).\n\n```\n";
  for (const std::string& line : bench_conditions(mapping_front(), result)) text += line + "\n";
  text += "```\n\n## All goals\n" + figures_page(mapping_goals(result), "goals");
  for (const std::string& group : figure_groups(result)) {
    if (group == "bounds") continue;
    text += "\n## " + group + "\n" + figures_page(result, group) + tables_page(result, group);
  }
  const firmware::Json sweep = mapping_sweep_tables(result);
  if (!sweep["tables"].empty())
    text += std::string("\n## Error over run time\n\n") + kMappingSweepWords + "\n";
  for (const BenchPicture& picture : mapping_pictures(result))
    text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
  for (const std::string& group : figure_groups(sweep))
    text += "\n### " + group + "\n" + tables_page(sweep, group);
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace

PeerFront mapping_front() {
  PeerFront front;
  front.name = "mapping";
  front.file = "bench-local-map";
  front.about = "The local map beside PCL: run time, memory, normals; error of segments over run time";
  front.footer =
      "Thread CPU time on recorded scans and in a simulated hall. docs/mapping.md tells what the map is.\n"
      "Examples:\n"
      "  sortie bench mapping --out out/mapping\n"
      "  sortie bench mapping --only sweep --json\n"
      "  sortie bench mapping --only peers --every 35 --count";
  front.options = {{"--stride", 2, "Every n-th point of the recorded scans", 1, 1000000},
                   {"--every", 10, "Scans between two looks at PCL", 1, 1000000},
                   {"--count", false, "Also count the instructions of each step: minutes", 0, 0},
                   choice("--only", "One part alone", {"peers", "insertion", "normals", "sweep"}),
                   choice("--stream", "One stream of the sweep alone", {"walk", "dense", "hall"}),
                   {"--file", std::string(), "Another recorded drive (.rls)", 0, 0, {}, "FILE"}};
  front.on_one_line = true;
  front.finish = mark_mapping_fronts;
  front.conditions = mapping_settings;
  front.pictures = mapping_pictures;
  front.print = print_mapping;
  front.page = mapping_page;
  return front;
}

}  // namespace sortie::toolchain
