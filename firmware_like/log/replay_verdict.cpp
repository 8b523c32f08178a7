// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay_verdict.hpp"

#include <iostream>

namespace sortie::firmware {

namespace {

std::string extent(const ReplayOutcome& outcome, bool has_ticks, bool is_part) {
  const rt::Tick last = outcome.first_tick + outcome.results.ticks - 1;
  const std::string ticks = std::to_string(last - outcome.begin_tick + 1) + " ticks";
  const std::uint64_t jobs = has_ticks ? outcome.compared_jobs : outcome.results.counters.at("jobs");
  return std::to_string(jobs) + " jobs in " + ticks +
         (is_part ? " (" + std::to_string(outcome.begin_tick) + " to " + std::to_string(last) + ")" : "");
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

std::string passed_line(const LogFile& log, const ReplayOutcome& outcome, bool is_part) {
  const bool has_ticks = log.header().has_ticks;
  return "passed  " + extent(outcome, has_ticks, is_part) + " give digest " + outcome.results.digest +
         (has_ticks ? ", as recorded" : "");
}

int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code) {
  if (damage.empty() || accept_damage) return code;
  std::cerr << program << ": " << damage << "; add --accept-damage if that is enough\n";
  return 3;
}

}  // namespace sortie::firmware
