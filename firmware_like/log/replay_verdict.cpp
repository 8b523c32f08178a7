// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay_verdict.hpp"

#include <algorithm>
#include <iostream>

#include "firmware_like/scene/json.hpp"

namespace sortie::firmware {

namespace {

std::string extent(const ReplayOutcome& outcome, bool has_ticks, bool is_part) {
  const rt::Tick last = outcome.first_tick + outcome.results.ticks - 1;
  const std::string ticks = std::to_string(last - outcome.begin_tick + 1) + " ticks";
  const std::uint64_t jobs = has_ticks ? outcome.compared_jobs : outcome.results.counters.at("jobs");
  return std::to_string(jobs) + " jobs in " + ticks +
         (is_part ? " (" + std::to_string(outcome.begin_tick) + " to " + std::to_string(last) + ")" : "");
}

std::string passed_line(const LogFile& log, const ReplayOutcome& outcome, bool is_part) {
  const bool has_ticks = log.header().has_ticks;
  return "passed  " + extent(outcome, has_ticks, is_part) + " give digest " + outcome.results.digest +
         (has_ticks ? ", as recorded" : "");
}

}  // namespace

std::vector<std::string> check_failures(const LogFile& log, const ReplayOutcome& outcome) {
  std::vector<std::string> failures = outcome.failures;
  if (outcome.divergence) failures.push_back(describe(*outcome.divergence));
  const std::string recorded = hex(outcome.recorded.all);
  if (log.header().has_ticks && !outcome.divergence && recorded != outcome.results.digest) {
    failures.push_back("the digest differs from the log's although no job does: " + recorded + " in the log");
  }
  for (const char* name : {"samples_missing", "samples_damaged"}) {
    if (const auto count = outcome.results.counters.at(name); count != 0) {
      failures.push_back(std::to_string(count) + " " + name +
                         ": the log does not hold all that its jobs consumed");
    }
  }
  return failures;
}

void print_check(const LogFile& log, const ReplayOutcome& outcome, const std::vector<std::string>& failures,
                 bool is_part, bool json) {
  if (json) {
    Json object = to_json(outcome.results);
    object["recorded_digest"] = log.header().has_ticks ? hex(outcome.recorded.all) : "";
    object["compared_jobs"] = outcome.compared_jobs;
    object["passed"] = failures.empty();
    object["failures"] = failures;
    if (const auto& divergence = outcome.divergence) {
      object["divergence"] = {{"tick", divergence->tick},     {"group", divergence->group},
                              {"task", divergence->task},     {"field", divergence->field},
                              {"was", divergence->was},       {"is", divergence->is},
                              {"jobs", outcome.diverged_jobs}};
    }
    std::cout << object.dump(2) << "\n";
    return;
  }
  for (const std::string& warning : outcome.results.warnings) {
    // These are told otherwise.
    const bool failed = std::find(failures.begin(), failures.end(), warning) != failures.end();
    if (warning != outcome.damage && !failed) std::cerr << "warning: " << warning << "\n";
  }
  for (const std::string& failure : failures) std::cout << "FAILED  " << failure << "\n";
  if (failures.empty()) std::cout << passed_line(log, outcome, is_part) << "\n";
}

int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code) {
  if (damage.empty() || accept_damage) return code;
  std::cerr << program << ": " << damage << "; add --accept-damage if that is enough\n";
  return 3;
}

}  // namespace sortie::firmware
