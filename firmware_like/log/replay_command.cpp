// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay_command.hpp"

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

}  // namespace

void add_scene_option(Command& command, std::string& scene) {
  command.add_option("--scene", scene, "Another scene than the log's own; needed for imported logs");
}

void add_span_options(Command& command, ReplayOptions& options, bool has_index) {
  const std::string begin = "Begin there: seconds since the start or @tick";
  command
      .add_option("--from", options.from,
                  has_index ? begin + "; the state comes from the nearest keyframe" : begin)
      ->type_name("TIME");
  command.add_option("--to", options.to, "End before that time or @tick")->type_name("TIME");
  command
      .add_option("--keyframes", options.keyframes,
                  std::string(has_index ? "Keyframes of `index`" : "Keyframes") + ", if not LOG.keyframes")
      ->type_name("FILE");
}

void add_map_options(Command& command, KeptMapPaths& maps) {
  command.add_option("--map", maps.map, "The kept map that the run began with")->type_name("FILE");
  command.add_option("--targets", maps.targets, "The targets that the run began with")->type_name("FILE");
  command.add_option("--images", maps.images, "The images that the run began with")->type_name("FILE");
}

void add_threads_option(Command& command, ReplayOptions& options) {
  command.add_flag("--threads", options.threaded, "One worker a group; the outputs must not change");
}

void add_fault_option(Command& command, ReplayOptions& options) {
  command.add_option("--fault", options.fault, "Flip a bit of a task's output: task@tick or task.byte@tick");
}

void add_record_option(Command& command, ReplayOptions& options) {
  command.add_option("--record", options.record, "Write a log of this replay")->type_name("LOG");
}

void add_damage_option(Command& command, bool& accept_damage) {
  command.add_flag("--accept-damage", accept_damage,
                   "The good part of a damaged log is enough: do not exit with 3");
}

void add_acceptance_options(Command& command, ReplayCommand& options) {
  command.add_flag("--accept-unused", options.replay.accept_unused,
                   "A channel of the log of which nothing is used is meant: do not exit with 1");
  add_damage_option(command, options.accept_damage);
}

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

int end_check(const std::string& program, const LogFile& log, const ReplayOutcome& outcome,
              const std::vector<std::string>& failures, const ReplayCommand& command, bool json) {
  const bool is_part = !command.replay.from.empty() || !command.replay.to.empty();
  print_check(log, outcome, failures, is_part, json);
  return code_with_damage(program, outcome.damage, command.accept_damage, failures.empty() ? 0 : 1);
}

int code_with_damage(const std::string& program, const std::string& damage, bool accept_damage, int code) {
  if (damage.empty() || accept_damage) return code;
  std::cerr << program << ": " << damage << "; add --accept-damage if that is enough\n";
  return 3;
}

}  // namespace sortie::firmware
