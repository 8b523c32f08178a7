// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/sweep_report.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <set>

#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

firmware::Json number(double value) {
  return std::isfinite(value) ? firmware::Json(value) : firmware::Json(nullptr);
}

std::set<std::string> error_names(const Sweep& sweep) {
  std::set<std::string> names;
  for (const SweepCell& cell : sweep.cells) {
    for (const auto& [name, unused] : cell.errors) names.insert(name);
  }
  return names;
}

// The one that counts first, then what else tells one cell from another, as far as a line has room.
std::vector<std::string> table_errors(const Sweep& sweep) {
  std::vector<std::string> chosen;
  if (!sweep.error.empty()) chosen.push_back(sweep.error);
  const std::set<std::string> known = error_names(sweep);
  for (const char* name :
       {"ate_rmse_m", "inclination_rmse_deg", "heading_rmse_deg", "map_disagreement", "map_missed"}) {
    if (known.count(name) != 0 && name != sweep.error && chosen.size() < 3) chosen.push_back(name);
  }
  return chosen;
}

bool counts_instructions(const Sweep& sweep) {
  return std::any_of(sweep.cells.begin(), sweep.cells.end(),
                     [](const SweepCell& cell) { return cell.instructions_per_s > 0; });
}

std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string cell_name(const SweepCell& cell) {
  std::string name;
  for (const std::string& value : cell.values) name += (name.empty() ? "" : ", ") + value;
  return name;
}

void print_sweep(std::ostream& out, const Sweep& sweep, bool colour) {
  const std::vector<std::string> errors = table_errors(sweep);
  bool has_voxels = false;
  for (const SweepCell& cell : sweep.cells) has_voxels = has_voxels || cell.voxels != 0;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> head = sweep.keys;
  head.insert(head.end(), errors.begin(), errors.end());
  if (has_voxels) head.insert(head.end(), {"voxels", "refused"});
  const bool counted = counts_instructions(sweep);
  for (const char* name : {"memory MB", "load us/s"}) head.push_back(name);
  if (counted) head.push_back("Minstr/s");
  for (const char* name : {"task", "p50 us", "p99 us", "max us", "jobs"}) head.push_back(name);
  rows.push_back(head);
  for (const SweepCell& cell : sweep.cells) {
    std::vector<std::string> row = cell.values;
    for (const std::string& name : errors) {
      const auto value = cell.errors.find(name);
      row.push_back(value == cell.errors.end() ? "-" : firmware::format_short(value->second));
    }
    if (has_voxels)
      row.insert(row.end(),
                 {firmware::group_digits(cell.voxels), firmware::group_digits(cell.voxels_refused)});
    row.push_back(firmware::format_short(static_cast<double>(cell.memory_bytes) * 1e-6));
    row.push_back(firmware::format_short(cell.load_us_per_s));
    if (counted) row.push_back(firmware::format_short(1e-6 * cell.instructions_per_s));
    const std::size_t before = row.size();
    for (const SweepTiming& timing : cell.timing) {
      if (row.size() != before) {  // a second task continues below the first
        rows.push_back(std::move(row));
        row.assign(before, "");
      }
      row.insert(row.end(),
                 {timing.task, firmware::format_short(timing.p50_us), firmware::format_short(timing.p99_us),
                  firmware::format_short(timing.max_us), firmware::group_digits(timing.n)});
    }
    std::string mark = std::string(cell.on_front ? "*" : "") + (cell.profile_choice ? "<" : "");
    std::vector<std::string>& first =
        cell.timing.size() > 1 ? rows[rows.size() - cell.timing.size() + 1] : row;
    first.push_back(mark);
    rows.push_back(std::move(row));
  }
  std::vector<std::size_t> width(head.size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < head.size() && i < row.size(); ++i)
      width[i] = std::max(width[i], row[i].size());
  }
  out << "scene " << sweep.scene << ", " << firmware::format_short(sweep.duration_s) << " s, each cell "
      << sweep.repeat << " x; load: run time per second of robot time, the shortest of each job\n";
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto& row = rows[r];
    const bool bold = colour && row.size() > head.size() && row.back().find('<') != std::string::npos;
    if (bold) out << "\033[1m";
    for (std::size_t i = 0; i < head.size() && i < row.size(); ++i)
      out << (i == 0 ? "" : "  ")
          << (row[i].size() > width[i] ? row[i] : firmware::pad_left(row[i], width[i]));
    if (row.size() > head.size()) out << " " << row.back();
    out << (bold ? "\033[0m" : "") << "\n";
  }
  if (sweep.error.empty()) {
    out << "< profile\n";
  } else {
    out << "* no other cell is as cheap (within 5 %) and better in " << sweep.error << "   < profile\n";
  }
  for (const std::string& warning : sweep.warnings) out << "warning   " << warning << "\n";
}

SweepFigures sweep_figures(const Sweep& sweep) {
  SweepFigures figures;
  figures.plot = plot_sweep(sweep);
  const std::vector<std::string> errors = table_errors(sweep);
  figures.head = sweep.keys;
  for (std::string name : errors) {
    std::replace(name.begin(), name.end(), '_', ' ');
    figures.head.push_back(std::move(name));
  }
  const bool counted = counts_instructions(sweep);
  figures.head.insert(figures.head.end(), {"memory MB", "load \u00b5s/s"});
  if (counted) figures.head.push_back("Minstr/s");
  figures.head.insert(figures.head.end(), {"p50 \u00b5s", "p99 \u00b5s", "max \u00b5s", "jobs", ""});
  for (const SweepCell& cell : sweep.cells) {
    std::vector<std::string> row = cell.values;
    for (const std::string& name : errors) {
      const auto value = cell.errors.find(name);
      row.push_back(value == cell.errors.end() ? "-" : firmware::format_short(value->second));
    }
    row.push_back(firmware::format_short(static_cast<double>(cell.memory_bytes) * 1e-6));
    row.push_back(firmware::format_short(cell.load_us_per_s));
    if (counted) row.push_back(firmware::format_short(1e-6 * cell.instructions_per_s));
    // Of several tasks the one whose jobs are the longest.
    const auto longest =
        std::max_element(cell.timing.begin(), cell.timing.end(),
                         [](const SweepTiming& a, const SweepTiming& b) { return a.max_us < b.max_us; });
    if (longest != cell.timing.end())
      row.insert(row.end(), {firmware::format_short(longest->p50_us), firmware::format_short(longest->p99_us),
                             firmware::format_short(longest->max_us), firmware::group_digits(longest->n)});
    row.push_back(std::string(cell.on_front ? "*" : "") + (cell.profile_choice ? "<" : ""));
    figures.rows.push_back(std::move(row));
  }
  figures.note = "* no other is as cheap (within 5 %) and better; < what the profile says. Each " +
                 std::to_string(sweep.repeat) + " x over " + firmware::format_short(sweep.duration_s) +
                 " s; load: run time per second of the robot's, the shortest of each job.";
  return figures;
}

firmware::Json to_json(const Sweep& sweep) {
  const bool counted = counts_instructions(sweep);
  firmware::Json cells = firmware::Json::array();
  for (const SweepCell& cell : sweep.cells) {
    firmware::Json values = firmware::Json::object();
    for (std::size_t i = 0; i < sweep.keys.size(); ++i) values[sweep.keys[i]] = cell.values[i];
    firmware::Json errors = firmware::Json::object();
    for (const auto& [name, value] : cell.errors) errors[name] = number(value);
    firmware::Json tasks = firmware::Json::array();
    for (const SweepTiming& timing : cell.timing) {
      tasks.push_back({{"name", timing.task},
                       {"n", timing.n},
                       {"p50_us", number(timing.p50_us)},
                       {"p99_us", number(timing.p99_us)},
                       {"max_us", number(timing.max_us)}});
    }
    cells.push_back(
        {{"values", std::move(values)},
         {"profile_choice", cell.profile_choice},
         {"on_front", cell.on_front},
         {"errors", std::move(errors)},
         {"digest", cell.digest},
         {"voxels", cell.voxels},
         {"voxels_refused", cell.voxels_refused},
         {"memory_bytes", cell.memory_bytes},
         {"load_us_per_s", number(cell.load_us_per_s)},
         {"instructions_per_s", counted ? number(cell.instructions_per_s) : firmware::Json(nullptr)},
         {"tasks", std::move(tasks)}});
  }
  return firmware::Json{{"scene", sweep.scene},
                        {"knobs", sweep.keys},
                        {"tasks", sweep.tasks},
                        {"error", sweep.error},
                        {"cost", "load_us_per_s"},
                        {"repeat", sweep.repeat},
                        {"duration_s", number(sweep.duration_s)},
                        {"cells", std::move(cells)},
                        {"machine", firmware::machine_description()},
                        {"compiler", firmware::compiler_description()},
                        {"warnings", sweep.warnings}};
}

void write_sweep_csv(std::ostream& out, const Sweep& sweep) {
  const std::set<std::string> errors = error_names(sweep);
  for (const std::string& key : sweep.keys) out << field(key) << ",";
  out << "profile_choice,on_front";
  for (const std::string& name : errors) out << "," << field(name);
  const bool counted = counts_instructions(sweep);
  out << ",voxels,voxels_refused,memory_bytes,load_us_per_s";
  if (counted) out << ",instructions_per_s";
  for (const std::string& task : sweep.tasks) {
    for (const char* figure : {"_n", "_p50_us", "_p99_us", "_max_us"}) out << "," << field(task + figure);
  }
  out << ",digest\n";
  for (const SweepCell& cell : sweep.cells) {
    for (const std::string& value : cell.values) out << field(value) << ",";
    out << cell.profile_choice << "," << cell.on_front;
    for (const std::string& name : errors) {
      const auto value = cell.errors.find(name);
      out << ",";
      if (value != cell.errors.end() && std::isfinite(value->second))
        out << firmware::format_exact(value->second);
    }
    out << "," << cell.voxels << "," << cell.voxels_refused << "," << cell.memory_bytes << ","
        << firmware::format_exact(cell.load_us_per_s);
    if (counted) out << "," << firmware::format_exact(cell.instructions_per_s);
    for (const SweepTiming& timing : cell.timing) {
      out << "," << timing.n << "," << firmware::format_exact(timing.p50_us) << ","
          << firmware::format_exact(timing.p99_us) << "," << firmware::format_exact(timing.max_us);
    }
    out << "," << cell.digest << "\n";
  }
}

}  // namespace sortie::toolchain
