// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <iomanip>
#include <ostream>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/sweep/sweep_report.hpp"
#include "toolchain/sweep/sweep_set.hpp"

namespace sortie::toolchain {

namespace {

firmware::Json to_json(const Spread& spread) {
  return {{"mean", spread.mean}, {"low", spread.low}, {"high", spread.high}};
}

// As CSV has it: what is a quote inside stands twice.
auto csv_text(const std::string& text) { return std::quoted(text, '"', '"'); }

std::string range_text(const Spread& spread) {
  return firmware::format_short(spread.mean) + " (" + firmware::format_short(spread.low) + " to " +
         firmware::format_short(spread.high) + ")";
}

void write_spread_csv(std::ostream& out, const SweepSet& set) {
  for (const std::string& key : set.logs.front().sweep.keys) out << csv_text(key) << ",";
  out << "logs,profile_choice,on_front";
  for (const std::string& name : {set.error, std::string("load_us_per_s")})
    for (const char* figure : {"_mean", "_low", "_high"}) out << "," << csv_text(name + figure);
  out << "\n";
  for (const SweepSpread& row : set.spread) {
    for (const std::string& value : row.values) out << csv_text(value) << ",";
    out << row.logs << "," << row.profile_choice << "," << row.on_front;
    for (const Spread& spread : {row.error, row.load_us_per_s})
      for (const double figure : {spread.mean, spread.low, spread.high})
        out << "," << (row.logs == 0 ? std::string() : firmware::format_exact(figure));
    out << "\n";
  }
}

}  // namespace

std::vector<TextRow> spread_rows(const SweepSet& set) {
  TextRow head = set.logs.front().sweep.keys;
  head.insert(head.end(), {"logs", set.error, "load us/s"});
  std::vector<TextRow> rows{std::move(head)};
  for (const SweepSpread& spread : set.spread) {
    TextRow row = spread.values;
    const bool any = spread.logs != 0;
    row.insert(row.end(), {std::to_string(spread.logs), any ? range_text(spread.error) : "-",
                           any ? range_text(spread.load_us_per_s) : "-"});
    if (spread.on_front || spread.profile_choice)
      row.push_back(sweep_marks(spread.on_front, spread.profile_choice));
    rows.push_back(std::move(row));
  }
  return rows;
}

void print_sweep_set(std::ostream& out, const SweepSet& set, bool colour) {
  for (const LogSweep& log : set.logs) {
    if (set.logs.size() > 1) out << "log   " << log.log << "\n";
    print_sweep(out, log.sweep, colour);
    if (set.logs.size() > 1) out << "\n";
  }
  if (!set.spread.empty()) {
    out << "over all logs: mean (lowest to highest)\n";
    print_columns(out, spread_rows(set));
  }
  for (const std::string& warning : set.warnings) out << "warning   " << warning << "\n";
}

firmware::Json to_json(const SweepSet& set) {
  if (set.logs.size() == 1) {
    firmware::Json object = to_json(set.logs.front().sweep);
    object["log"] = set.logs.front().log;
    return object;
  }
  firmware::Json logs = firmware::Json::array();
  for (const LogSweep& log : set.logs) {
    logs.push_back(to_json(log.sweep));
    logs.back()["log"] = log.log;
  }
  firmware::Json rows = firmware::Json::array();
  for (const SweepSpread& row : set.spread) {
    firmware::Json values = firmware::Json::object();
    for (std::size_t i = 0; i < row.values.size(); ++i)
      values[set.logs.front().sweep.keys[i]] = row.values[i];
    rows.push_back({{"values", std::move(values)},
                    {"logs", row.logs},
                    {"error", row.logs == 0 ? firmware::Json(nullptr) : to_json(row.error)},
                    {"load_us_per_s", row.logs == 0 ? firmware::Json(nullptr) : to_json(row.load_us_per_s)},
                    {"profile_choice", row.profile_choice},
                    {"on_front", row.on_front}});
  }
  return firmware::Json{{"logs", std::move(logs)},
                        {"error", set.error},
                        {"spread", std::move(rows)},
                        {"warnings", set.warnings}};
}

std::string sweep_file(const SweepSet& set, std::size_t i) {
  return set.logs.size() == 1 ? "sweep" : "sweep-" + std::to_string(i + 1);
}

void write_sweep_set(const std::string& folder, const SweepSet& set, const firmware::Json& object) {
  std::filesystem::create_directories(folder);
  write_file(folder + "/sweep.json", object.dump(2) + "\n");
  for (std::size_t i = 0; i < set.logs.size(); ++i) {
    const Sweep& sweep = set.logs[i].sweep;
    const std::string name = folder + "/" + sweep_file(set, i);
    write_file(name + ".csv", [&sweep](std::ostream& out) { write_sweep_csv(out, sweep); });
    write_file(name + ".svg", render(plot_sweep(sweep)));
  }
  if (!set.spread.empty())
    write_file(folder + "/spread.csv", [&set](std::ostream& out) { write_spread_csv(out, set); });
  write_file(folder + "/sweep.md", sweep_page(set, object.value("command", "")));
}

}  // namespace sortie::toolchain
