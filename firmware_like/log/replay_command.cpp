// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/log/replay_command.hpp"

#include "firmware_like/log/replay_verdict.hpp"

namespace sortie::firmware {

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

void add_map_option(Command& command, std::string& map) {
  command.add_option("--map", map, "The kept map that the run began with")->type_name("FILE");
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

int end_check(const std::string& program, const LogFile& log, const ReplayOutcome& outcome,
              const std::vector<std::string>& failures, const ReplayCommand& command, bool json) {
  const bool is_part = !command.replay.from.empty() || !command.replay.to.empty();
  print_check(log, outcome, failures, is_part, json);
  return code_with_damage(program, outcome.damage, command.accept_damage, failures.empty() ? 0 : 1);
}

}  // namespace sortie::firmware
