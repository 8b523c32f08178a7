// SPDX-License-Identifier: BSD-3-Clause
// The declared table and the chains, as JSON and as text.
#include "firmware_like/result/results_schedule.hpp"

#include <cmath>
#include <ostream>

#include "firmware_like/scene/json_reader.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::firmware {

namespace {

std::string percent(double share) { return format_fixed(100.0 * share, 1) + " %"; }
std::string where(int core) { return core < 0 ? "any" : std::to_string(core); }
std::string bound(double us) { return std::isfinite(us) ? format_short(us) : "none"; }

void row(std::ostream& out, const std::string& name, const std::vector<std::string>& cells) {
  out << pad_right(shorten(name, 18), 18);
  for (const std::string& cell : cells) out << pad_left(cell, 10);
  out << '\n';
}

}  // namespace

Json to_json(const ScheduleResult& schedule) {
  Json groups = Json::array();
  for (const ScheduledGroup& group : schedule.groups) groups.push_back(json_of(group));
  Json cores = Json::array();
  for (const ScheduledCore& core : schedule.cores) {
    Json levels = Json::array();
    for (const double share : core.utilisation) levels.push_back(json_number(share));
    cores.push_back({{"core", core.core},
                     {"utilisation", std::move(levels)},
                     {"worst_tick_us", json_number(core.worst_tick_us)},
                     {"longest_block_us", json_number(core.longest_block_us)}});
  }
  Json object = json_of(schedule);
  object["groups"] = std::move(groups);
  object["cores"] = std::move(cores);
  object["findings"] = schedule.findings;
  return object;
}

Json to_json(const ChainResult& chain) {
  Json object = json_of(chain);
  if (chain.reaction.count + chain.age.count + chain.unmeasured == 0) return object;
  object["measured_reaction"] = json_of(chain.reaction);
  object["measured_age"] = json_of(chain.age);
  if (chain.finished.count != 0) object["measured_finished"] = json_of(chain.finished);
  object["source_interval_max_us"] = json_number(chain.source_interval_max_us);
  object["unmeasured"] = chain.unmeasured;
  return object;
}

void print_schedule(std::ostream& out, const ScheduleResult& schedule) {
  row(out, "group [us]", {"period", "phase", "deadline", "core", "priority", "budget", "load", "response"});
  for (const ScheduledGroup& group : schedule.groups) {
    row(out, group.name,
        {format_short(group.period_us), format_short(group.phase_us), format_short(group.deadline_us),
         where(group.core), std::to_string(group.priority), format_short(group.budget_us),
         percent(group.utilisation), bound(group.response_us) + (group.fits ? "" : "!")});
  }
  for (const ScheduledCore& core : schedule.cores) {
    out << pad_right(core.core < 0 ? "one processor" : "core " + std::to_string(core.core), 18) << "  load "
        << percent(core.utilisation.empty() ? 0.0 : core.utilisation[0]) << ", worst tick "
        << format_short(core.worst_tick_us) << " us waiting, longest block "
        << format_short(core.longest_block_us) << " us\n";
  }
  out << pad_right("table", 18) << "  hyperperiod "
      << (schedule.hyperperiod_ticks == 0 ? std::string("longer than 2^63")
                                          : group_digits(schedule.hyperperiod_ticks))
      << " ticks of " << format_short(schedule.base_tick_us) << " us, "
      << (schedule.harmonic ? "harmonic" : "not harmonic") << ", "
      << (schedule.schedulable ? "schedulable" : "not schedulable") << '\n';
  for (const std::string& finding : schedule.findings)
    out << pad_right("note", 18) << "  " << finding << '\n';
}

void print_chains(std::ostream& out, const std::vector<ChainResult>& chains) {
  if (chains.empty()) return;
  bool measured = false;
  for (const ChainResult& chain : chains) measured = measured || chain.reaction.count != 0;
  // Two lines a chain: a bound and what was measured below it stand side by side.
  row(out, "chain [us]",
      measured ? std::vector<std::string>{"", "bound", "p50", "p99", "max", "count", "allowed"}
               : std::vector<std::string>{"", "bound", "allowed"});
  for (const ChainResult& chain : chains) {
    const auto line = [&](const std::string& name, const char* what, double computed,
                          const ChainFigures& figures, double allowed) {
      std::vector<std::string> cells{what, (chain.exact ? "" : "<") + format_short(computed)};
      if (measured) {
        for (const double us : {figures.p50_us, figures.p99_us, figures.max_us})
          cells.push_back(figures.count == 0 ? "-" : format_short(us));
        cells.push_back(std::to_string(figures.count));
      }
      cells.push_back(allowed > 0 ? format_short(allowed) : "-");
      row(out, name, cells);
    };
    line(chain.name, "reaction", chain.reaction_us, chain.reaction, chain.max_reaction_us);
    line("", "age", chain.age_us, chain.age, chain.max_age_us);
  }
}

}  // namespace sortie::firmware
