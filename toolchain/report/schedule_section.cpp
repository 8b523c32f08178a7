// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "firmware_like/scene/text_format.hpp"
#include "toolchain/report/page_sections.hpp"

namespace sortie::toolchain {

namespace {

std::string head(const char* title, const char* first, std::initializer_list<const char*> columns) {
  std::string out = std::string("<h2>") + title + "</h2>\n<table><thead><tr><th>" + first + "</th>";
  for (const char* column : columns) out += std::string("<th class=\"n\">") + column + "</th>";
  return out + "</tr></thead>\n<tbody>";
}

std::string group_rows(const firmware::ScheduleResult& schedule) {
  std::string out;
  for (const firmware::ScheduledGroup& group : schedule.groups) {
    out += "<tr>" + table_cell(group.name, "t") + table_cell(std::to_string(group.priority)) +
           table_cell(group.core < 0 ? "any" : std::to_string(group.core)) +
           table_cell(firmware::format_short(group.period_us)) +
           table_cell(firmware::format_short(group.phase_us)) +
           table_cell(firmware::format_short(group.budget_us)) +
           table_cell(firmware::format_fixed(100 * group.utilisation, 1) + " %") +
           table_cell(std::isfinite(group.response_us) ? firmware::format_short(group.response_us) : "none",
                      group.fits ? "n" : "n bad") +
           table_cell(firmware::format_short(group.deadline_us)) + "</tr>\n";
  }
  return out;
}

std::string measured(const firmware::ChainFigures& figures, double bound_us) {
  if (figures.count == 0) return table_cell("-") + table_cell("-") + table_cell("-");
  return table_cell(firmware::format_short(figures.p50_us)) +
         table_cell(firmware::format_short(figures.p99_us)) +
         table_cell(firmware::format_short(figures.max_us), figures.max_us > bound_us ? "n bad" : "n");
}

std::string chain_rows(const firmware::ChainResult& chain) {
  std::string path;
  for (const std::string& step : chain.path) path += (path.empty() ? "" : " \u2192 ") + step;
  const auto allowed = [](double us) { return us > 0 ? firmware::format_short(us) : std::string("-"); };
  // Samples that come less often than promised make outputs older than computed: that is the source's doing.
  const double late_source = std::fmax(0.0, chain.source_interval_max_us - chain.source_interval_us);
  return "<tr>" + table_cell(chain.name, "t") + table_cell("reaction") +
         table_cell(firmware::format_short(chain.reaction_us)) + measured(chain.reaction, chain.reaction_us) +
         table_cell(std::to_string(chain.reaction.count)) + table_cell(allowed(chain.max_reaction_us)) +
         "</tr>\n<tr>" + table_cell(path, "t") + table_cell("age") +
         table_cell(firmware::format_short(chain.age_us)) + measured(chain.age, chain.age_us + late_source) +
         table_cell(std::to_string(chain.age.count)) + table_cell(allowed(chain.max_age_us)) + "</tr>\n";
}

}  // namespace

std::string schedule_section(const firmware::Results& results) {
  std::string out;
  const firmware::ScheduleResult& schedule = results.schedule;
  if (!schedule.groups.empty()) {
    out += head("Schedule", "group",
                {"priority", "core", "period", "phase", "budget", "load", "worst response", "deadline"}) +
           group_rows(schedule) +
           "</tbody></table>\n<p class=\"note\">Computed from declared budgets, in microseconds. ";
    for (const std::string& finding : schedule.findings) out += escape_xml(finding) + ". ";
    out += "</p>\n";
  }
  if (!results.chains.empty()) {
    out += head("Chains", "chain", {"", "bound", "p50", "p99", "max", "count", "allowed"});
    for (const firmware::ChainResult& chain : results.chains) out += chain_rows(chain);
    out +=
        "</tbody></table>\n<p class=\"note\">Reaction: from a sample to the deadline of the first output "
        "that knows of "
        "it. Age: of the newest sample behind an output at its deadline. Computed from the table, and "
        "measured in "
        "this run; microseconds.</p>\n";
  }
  return out;
}

}  // namespace sortie::toolchain
