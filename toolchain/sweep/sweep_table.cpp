// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <ostream>
#include <set>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/sweep/sweep_report.hpp"

namespace sortie::toolchain {

namespace {

// The one that counts first, then what else tells one cell from another, as far as a line has room.
std::vector<std::string> table_errors(const Sweep& sweep) {
  std::set<std::string> known;
  for (const SweepCell& cell : sweep.cells)
    for (const auto& [name, unused] : cell.errors) known.insert(name);
  std::vector<std::string> chosen;
  if (!sweep.error.empty()) chosen.push_back(sweep.error);
  for (const char* name :
       {"ate_rmse_m", "inclination_rmse_deg", "heading_rmse_deg", "map_disagreement", "map_missed"}) {
    if (known.count(name) != 0 && name != sweep.error && chosen.size() < 3) chosen.push_back(name);
  }
  return chosen;
}

// Values and errors of a cell.
TextRow row_of(const SweepCell& cell, const std::vector<std::string>& errors) {
  TextRow row = cell.values;
  for (const std::string& name : errors) {
    const auto value = cell.errors.find(name);
    row.push_back(value == cell.errors.end() ? "-" : firmware::format_short(value->second));
  }
  return row;
}

void add_costs(const SweepCell& cell, bool counted, TextRow& row) {
  row.push_back(firmware::format_short(static_cast<double>(cell.memory_bytes) * 1e-6));
  row.push_back(firmware::format_short(cell.load_us_per_s));
  if (counted) row.push_back(firmware::format_short(1e-6 * cell.instructions_per_s));
}

void add_times(const SweepTiming& timing, TextRow& row) {
  row.insert(row.end(), {firmware::format_short(timing.p50_us), firmware::format_short(timing.p99_us),
                         firmware::format_short(timing.max_us), firmware::group_digits(timing.n)});
}

// A cell's lines: a second task continues below the first.
void add_lines(const SweepCell& cell, TextRow row, std::vector<TextRow>& rows) {
  const std::size_t first = rows.size();
  const std::size_t before = row.size();
  for (const SweepTiming& timing : cell.timing) {
    if (row.size() != before) {
      rows.push_back(std::move(row));
      row.assign(before, "");
    }
    row.push_back(timing.task);
    add_times(timing, row);
  }
  rows.push_back(std::move(row));
  rows[first].push_back(sweep_marks(cell.on_front, cell.profile_choice));
}

std::vector<TextRow> lines_of(const Sweep& sweep) {
  const std::vector<std::string> errors = table_errors(sweep);
  const bool has_voxels = std::any_of(sweep.cells.begin(), sweep.cells.end(),
                                      [](const SweepCell& cell) { return cell.voxels != 0; });
  const bool counted = counts_instructions(sweep);
  TextRow head = sweep.keys;
  head.insert(head.end(), errors.begin(), errors.end());
  if (has_voxels) head.insert(head.end(), {"voxels", "refused"});
  head.insert(head.end(), {"memory MB", "load us/s"});
  if (counted) head.push_back("Minstr/s");
  head.insert(head.end(), {"task", "p50 us", "p99 us", "max us", "jobs"});
  std::vector<TextRow> rows{std::move(head)};
  for (const SweepCell& cell : sweep.cells) {
    TextRow row = row_of(cell, errors);
    if (has_voxels)
      row.insert(row.end(),
                 {firmware::group_digits(cell.voxels), firmware::group_digits(cell.voxels_refused)});
    add_costs(cell, counted, row);
    add_lines(cell, std::move(row), rows);
  }
  return rows;
}

}  // namespace

std::string sweep_marks(bool on_front, bool profile_choice) {
  return std::string(on_front ? "*" : "") + (profile_choice ? "<" : "");
}

bool counts_instructions(const Sweep& sweep) {
  return std::any_of(sweep.cells.begin(), sweep.cells.end(),
                     [](const SweepCell& cell) { return cell.instructions_per_s > 0; });
}

void print_columns(std::ostream& out, const std::vector<TextRow>& rows, bool colour) {
  std::vector<std::size_t> width(rows.front().size(), 0);
  for (const TextRow& row : rows)
    for (std::size_t i = 0; i < width.size() && i < row.size(); ++i)
      width[i] = std::max(width[i], row[i].size());
  for (const TextRow& row : rows) {
    const bool marked = row.size() > width.size();
    const bool bold = colour && marked && row.back().find('<') != std::string::npos;
    if (bold) out << "\033[1m";
    for (std::size_t i = 0; i < width.size() && i < row.size(); ++i)
      out << (i == 0 ? "" : "  ") << firmware::pad_left(row[i], width[i]);
    if (marked) out << " " << row.back();
    out << (bold ? "\033[0m" : "") << "\n";
  }
}

void print_sweep(std::ostream& out, const Sweep& sweep, bool colour) {
  out << "scene " << sweep.scene << ", " << firmware::format_short(sweep.duration_s) << " s, each cell "
      << sweep.repeat << " x; load: run time per second of robot time, the shortest of each job\n";
  print_columns(out, lines_of(sweep), colour);
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
    TextRow row = row_of(cell, errors);
    add_costs(cell, counted, row);
    // Of several tasks the one whose jobs are the longest.
    const auto longest =
        std::max_element(cell.timing.begin(), cell.timing.end(),
                         [](const SweepTiming& a, const SweepTiming& b) { return a.max_us < b.max_us; });
    if (longest != cell.timing.end()) add_times(*longest, row);
    row.push_back(sweep_marks(cell.on_front, cell.profile_choice));
    figures.rows.push_back(std::move(row));
  }
  figures.note = "* no other is as cheap (within 5 %) and better; < what the profile says. Each " +
                 std::to_string(sweep.repeat) + " x over " + firmware::format_short(sweep.duration_s) +
                 " s; load: run time per second of the robot's, the shortest of each job.";
  return figures;
}

}  // namespace sortie::toolchain
