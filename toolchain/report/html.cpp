// SPDX-License-Identifier: BSD-3-Clause
// The page: head line, tiles, warnings, tasks, trajectory, errors, latencies, memory, counters, what it ran
// on.
#include "toolchain/report/html.hpp"

#include <algorithm>
#include <cmath>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/page_sections.hpp"
#include "toolchain/report/page_style.hpp"
#include "toolchain/report/plots.hpp"
#include "toolchain/report/release_plots.hpp"

namespace sortie::toolchain {
namespace {

std::string esc(std::string_view text) { return escape_xml(text); }

std::string tile(const std::string& value, const std::string& unit, const std::string& name,
                 bool bad = false) {
  return std::string("<div class=\"tile") + (bad ? " bad" : "") + "\"><b>" + esc(value) + "<i>" + esc(unit) +
         "</i></b><span>" + esc(name) + "</span></div>";
}

double share_of(double part, double whole) { return whole > 0.0 ? part / whole : 0.0; }

struct Unit {
  std::string name;
  std::string unit;
};

/// "ate_rmse_m" -> {"ate rmse", "m"}.
Unit split_unit(const std::string& key) {
  for (const char* unit : {"_m", "_deg", "_percent", "_s", "_rad"}) {
    const std::string ending = unit;
    if (key.size() > ending.size() && key.ends_with(ending)) {
      std::string name = key.substr(0, key.size() - ending.size());
      std::replace(name.begin(), name.end(), '_', ' ');
      return {name, ending == "_percent" ? "%" : ending == "_deg" ? "\u00b0" : ending.substr(1)};
    }
  }
  std::string name = key;
  std::replace(name.begin(), name.end(), '_', ' ');
  return {name, ""};
}

std::string tiles(const ReportInput& input) {
  const firmware::Results& r = input.results;
  std::string out = "<div class=\"tiles\">";
  for (const char* key : {"ate_rmse_m", "inclination_rmse_deg", "drift_horizontal_percent"}) {
    const auto found = r.errors.find(key);
    if (found == r.errors.end()) continue;
    const Unit unit = split_unit(key);
    out += tile(firmware::format_short(found->second), unit.unit, unit.name);
  }
  std::uint64_t missed = 0;
  std::uint64_t jobs = 0;
  for (const firmware::TaskResult& task : r.tasks) {
    missed += task.missed;
    jobs += task.count;
  }
  if (!r.tasks.empty())
    out += tile(firmware::group_digits(missed), "", "of " + firmware::group_digits(jobs) + " jobs missed",
                missed > 0);
  out += tile(firmware::group_digits(r.ticks), "", "ticks");
  if (r.duration_s > 0.0) out += tile(firmware::format_short(r.duration_s), "s", "duration");
  if (r.speed > 0.0) out += tile(firmware::format_short(r.speed), "\u00d7", "real time");
  return out + "</div>\n";
}

std::string task_table(const firmware::Results& r) {
  std::string out =
      "<h2>Tasks</h2>\n<table><thead><tr><th>task</th><th>group</th><th class=\"n\">period</th><th "
      "class=\"n\">budget</th>"
      "<th class=\"n\">p50</th><th class=\"n\">p99</th><th class=\"n\">p99.9</th><th class=\"n\">max</th>"
      "<th>max of budget</th><th class=\"n\">jobs</th><th class=\"n\">missed</th></tr></thead>\n<tbody>";
  for (const firmware::TaskResult& t : r.tasks) {
    const double share = share_of(t.max_us, t.budget_us);
    out += "<tr>" + table_cell(t.name, "t") + table_cell(t.group, "t") +
           table_cell(firmware::format_short(t.period_us)) +
           table_cell(t.budget_us > 0.0 ? firmware::format_short(t.budget_us) : "-") +
           table_cell(firmware::format_short(t.p50_us)) + table_cell(firmware::format_short(t.p99_us)) +
           table_cell(firmware::format_short(t.p999_us)) + table_cell(firmware::format_short(t.max_us)) +
           "<td class=\"bar\">" +
           (t.budget_us > 0.0 ? render_bar(share, share > 1.0 ? kVermilion : kBlue, 90) + "<small>" +
                                    firmware::format_fixed(100.0 * share, share < 0.1 ? 1 : 0) + " %</small>"
                              : std::string()) +
           "</td>" + table_cell(firmware::group_digits(t.count)) +
           table_cell(firmware::group_digits(t.missed), t.missed > 0 ? "n bad" : "n") + "</tr>\n";
  }
  return out +
         "</tbody></table>\n<p class=\"note\">Times in microseconds; in a replay those of the replay.</p>\n";
}

std::string trajectory_section(const ReportInput& input) {
  if (input.estimate.empty() && input.located.empty() && input.errors.empty()) return {};
  std::string out = "<h2>Trajectory</h2>\n<div class=\"split\"><div>";
  const bool has_path = !input.located.empty() || std::any_of(input.estimate.begin(), input.estimate.end(),
                                                              [](const firmware::TimedPose& pose) {
                                                                return (pose.flags & rt::kTruthPosition) != 0;
                                                              });
  if (has_path) {
    const RunPaths paths{input.estimate, input.truth, input.located};
    out += render(plot_top(paths)) + render(plot_side(paths));
  }
  const auto some = [&](auto member) {
    return std::any_of(input.errors.begin(), input.errors.end(),
                       [member](const ErrorSample& e) { return std::isfinite(e.*member); });
  };
  if (some(&ErrorSample::position_m)) out += render(plot_position_error(input.errors));
  if (some(&ErrorSample::inclination_deg)) out += render(plot_orientation_error(input.errors));
  out += "</div><div>";
  if (!input.results.errors.empty()) {
    out +=
        "<table class=\"side\"><thead><tr><th>error</th><th class=\"n\"></th><th></th></tr></thead><tbody>";
    for (const auto& [name, value] : input.results.errors) {
      const Unit unit = split_unit(name);
      out += "<tr>" + table_cell(unit.name, "t") + table_cell(firmware::format_short(value)) +
             table_cell(unit.unit, "u") + "</tr>";
    }
    out += "</tbody></table>";
    if (!input.alignment.empty())
      out += "<p class=\"note\">Alignment before errors: " + esc(input.alignment) + ".</p>";
  }
  return out + "</div></div>\n";
}

std::string latency_section(const firmware::Results& r, const Plot& timeline) {
  std::string plots;
  for (const firmware::TaskResult& task : r.tasks) {
    if (!task.histogram.empty()) plots += render(plot_latency(task));
  }
  std::string out;
  if (has_releases(r.groups)) {
    out += "<h2>Releases</h2>\n" + render(plot_wake_up(r.groups)) + render(plot_response(r.groups)) +
           "<p class=\"note\">Releases that were left out count as late. Bins are 1 \u00b5s wide, from 64 "
           "\u00b5s on at "
           "most 1.6 %.</p>\n";
  }
  if (plots.empty() && timeline.series.empty()) return out;
  out += "<h2>Latency</h2>\n" + (timeline.series.empty() ? std::string() : render(timeline));
  return out + "<div class=\"grid\">" + plots + "</div>\n";
}

std::string pool_section(const firmware::Results& r) {
  if (r.pools.empty()) return {};
  std::string out =
      "<h2>Memory</h2>\n<table><thead><tr><th>pool</th><th>high water</th><th class=\"n\"></th><th "
      "class=\"n\">used</th>"
      "<th class=\"n\">capacity</th><th class=\"n\">bytes</th><th "
      "class=\"n\">refused</th></tr></thead>\n<tbody>";
  for (const firmware::PoolResult& p : r.pools) {
    const double share = share_of(static_cast<double>(p.high_water), static_cast<double>(p.capacity));
    out += "<tr>" + table_cell(p.name, "t") + "<td class=\"bar\">" +
           render_bar(share, p.refused > 0 ? kVermilion : kBlue, 220) + "</td>" +
           table_cell(firmware::format_fixed(100.0 * share, 0) + " %") +
           table_cell(firmware::group_digits(p.high_water)) + table_cell(firmware::group_digits(p.capacity)) +
           table_cell(firmware::group_digits(p.bytes)) +
           table_cell(firmware::group_digits(p.refused), p.refused > 0 ? "n bad" : "n") + "</tr>\n";
  }
  return out + "</tbody></table>\n";
}

std::string counter_section(const firmware::Results& r) {
  if (r.counters.empty()) return {};
  std::string out = "<h2>Counters</h2>\n<div class=\"counters\">";
  for (const auto& [name, value] : r.counters) {
    out += std::string("<div") + (value == 0 ? " class=\"zero\"" : "") + "><span>" + esc(name) +
           "</span><b>" + firmware::group_digits(value) + "</b></div>";
  }
  return out + "</div>\n";
}

std::string figure_tables(const std::vector<FigureTable>& tables) {
  std::string out;
  for (const FigureTable& table : tables) {
    if (table.rows.empty()) continue;
    out += "<h2>" + esc(table.title) + "</h2>\n<table class=\"side\"><tbody>";
    for (const FigureRow& row : table.rows)
      out += "<tr>" + table_cell(row.name, "t") + table_cell(row.value) + table_cell(row.unit, "u") + "</tr>";
    out += "</tbody></table>\n";
  }
  return out;
}

std::string sweep_section(const std::vector<SweepFigures>& sweeps) {
  std::string out;
  for (const SweepFigures& sweep : sweeps) {
    out += render(sweep.plot) + "<table><thead><tr>";
    for (const std::string& name : sweep.head) out += "<th class=\"n\">" + esc(name) + "</th>";
    out += "</tr></thead>\n<tbody>";
    for (const auto& row : sweep.rows) {
      out += "<tr>";
      for (const std::string& cell : row) out += table_cell(cell);
      out += "</tr>\n";
    }
    out += "</tbody></table>\n<p class=\"note\">" + esc(sweep.note) + "</p>\n";
  }
  return out.empty() ? out : "<h2>Error over run time</h2>\n" + out;
}

/// Wide plots stand alone, the others side by side.
std::string more_section(const std::vector<Plot>& plots) {
  constexpr double kWide = 700.0;
  std::string wide;
  std::string grid;
  for (const Plot& plot : plots) (plot.width > kWide ? wide : grid) += render(plot);
  if (!wide.empty()) wide = "<h2>Map</h2>\n" + wide;
  return grid.empty() ? wide : wide + "<h2>Series</h2>\n<div class=\"grid\">" + grid + "</div>\n";
}

std::string fact(const char* name, const std::string& value) {
  return value.empty() ? std::string() : std::string("<dt>") + name + "</dt><dd>" + esc(value) + "</dd>";
}

std::string left_out_section(const firmware::Results& r) {
  if (r.left_out.empty()) return {};
  std::string names;
  for (const std::string& task : r.left_out) names += (names.empty() ? "" : ", ") + task;
  return "<h2>Left out</h2>\n<p class=\"note\">This scene does without these tasks, which its vehicle could "
         "have: " +
         esc(names) + ". They are not scheduled and have no memory.</p>\n";
}

std::string subtitle(const ReportInput& input) {
  const std::string& vehicle = input.results.vehicle;
  return vehicle + (vehicle.empty() || input.source.empty() ? "" : " \u00b7 ") + input.source;
}

std::string page_head(const std::string& title) {
  return "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\"><head><meta "
         "charset=\"utf-8\"/>"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/><title>Sortie: " +
         esc(title) + "</title>\n<style>" + kPageStyle + "</style></head>\n<body><main>\n";
}

std::string page_end() { return "</main></body></html>\n"; }

// One run, from its tiles to its footer.
std::string body(const ReportInput& input) {
  const firmware::Results& r = input.results;
  std::string out = tiles(input);
  for (const std::string& warning : r.warnings) out += "<p class=\"warning\">" + esc(warning) + "</p>\n";
  if (!r.tasks.empty()) out += task_table(r);
  out += schedule_section(r);
  out += trajectory_section(input) + recognised_section(input.recognised) +
         latency_section(r, input.timeline) + pool_section(r) + counter_section(r);
  out += left_out_section(r);
  out += sweep_section(input.sweeps);
  out += figure_tables(input.tables) + more_section(input.more_plots) + doctor_section(r.doctor);
  return out + "<footer><dl>" + fact("digest", r.digest) + fact("profile", r.profile_hash) +
         fact("command", input.command) + fact("machine", r.machine) + fact("compiler", r.compiler) +
         "</dl></footer>\n";
}

}  // namespace

std::string render_report(const ReportInput& input) {
  const std::string scene = scene_name(input);
  return page_head(scene) + "<header><h1>" + esc(scene) + "</h1><p>" + esc(subtitle(input)) +
         "</p></header>\n" + body(input) + page_end();
}

std::string render_report(const std::vector<ReportInput>& inputs, const Plot& ground) {
  if (inputs.size() == 1) return render_report(inputs.front());
  std::string names;
  for (const ReportInput& input : inputs) names += (names.empty() ? "" : " + ") + scene_name(input);
  std::string out = page_head(names) + "<header><h1>" + esc(names) + "</h1><p>" +
                    std::to_string(inputs.size()) + " runs</p></header>\n";
  out += overview(inputs) + render(plot_ways(inputs, ground));
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    out += "<header class=\"run\" id=\"run" + std::to_string(i + 1) + "\"><h1>" + esc(scene_name(inputs[i])) +
           "</h1><p>" + esc(subtitle(inputs[i])) + "</p></header>\n" + body(inputs[i]);
  }
  return out + page_end();
}

}  // namespace sortie::toolchain
