// SPDX-License-Identifier: BSD-3-Clause
#include <filesystem>
#include <span>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/bench/figure_table.hpp"
#include "toolchain/sweep/sweep_report.hpp"
#include "toolchain/sweep/sweep_set.hpp"

namespace sortie::toolchain {

namespace {

std::string markdown_table(const TextRow& head, std::span<const TextRow> rows) {
  TextTable table{{head}, std::vector<bool>(head.size())};
  for (const TextRow& row : rows) {
    table.lines.push_back(row);
    table.lines.back().resize(head.size());
  }
  return markdown(table);
}

}  // namespace

std::string sweep_page(const SweepSet& set, const std::string& command) {
  std::string page =
      "# Error against run time\n\nWritten by `" + command +
      "`. A log a section, replayed with other values of the keys in its title. `<` is what the profile "
      "says, "
      "`*` what no other is as cheap as (within 5 %) and better than. Errors repeat to the bit; load is run "
      "time of the section's tasks per second of the robot's time, the shortest of each job, and moves with "
      "the machine; the times of jobs are those of the task with the longest one.\n\n```\n" +
      firmware::machine_description() + "; " + firmware::compiler_description() + "\n```\n";
  for (std::size_t i = 0; i < set.logs.size(); ++i) {
    const Sweep& sweep = set.logs[i].sweep;
    const SweepFigures figures = sweep_figures(sweep);
    const std::string keys = listed(sweep.keys);
    page += "\n## " + keys + ", " + sweep.scene + "\n\n`" +
            std::filesystem::path(set.logs[i].log).filename().string() + "`, " +
            firmware::format_short(sweep.duration_s) + " s, each cell " + std::to_string(sweep.repeat) +
            " x; run time of " + listed(sweep.tasks) + ".\n\n![" + keys + ": error over run time](" +
            sweep_file(set, i) + ".svg)\n\n" + markdown_table(figures.head, figures.rows);
    for (const std::string& warning : sweep.warnings) page += "\n" + warning + "\n";
  }
  for (const std::string& warning : set.warnings) page += "\n" + warning + "\n";
  if (set.spread.empty()) return page;
  std::vector<TextRow> rows = spread_rows(set);
  rows.front().push_back("");
  return page + "\n## Over all logs\n\nMean (lowest to highest).\n\n" +
         markdown_table(rows.front(), std::span(rows).subspan(1));
}

}  // namespace sortie::toolchain
