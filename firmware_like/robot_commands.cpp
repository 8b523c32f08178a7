// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/robot_commands.hpp"

#include <memory>

#include "firmware_like/doctor/doctor_command.hpp"
#include "firmware_like/live/live_options.hpp"
#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/result/results.hpp"

namespace sortie::firmware {

namespace {

constexpr const char* kProgram = "sortie";

struct RunOptions {
  LiveRunOptions live;
  bool json{};
  bool quiet{};
};

struct LogOptions : ReplayCommand {
  bool json{};
  bool quiet{};
};

void add_output(Command& command, bool& json, bool& quiet) {
  command.add_flag("--json", json, "Print one JSON object");
  command.add_flag("--quiet", quiet, "No progress bar; this program has none");
}

int run(const VehicleRegistry& vehicles, RunOptions& options) {
  const StopSignals stop;  // up to the last word
  options.live.interrupted = &StopSignals::asked();
  const LiveRunOutcome outcome = run_live(vehicles, nullptr, options.live);
  print_results(outcome.results, options.json, outcome.failures.empty() ? nullptr : &outcome.failures);
  tell_files(outcome);
  print_failures(outcome.failures, options.json);
  return outcome.stopped.empty() && outcome.failures.empty() ? 0 : 1;
}

int replay_log(const VehicleRegistry& vehicles, const LogOptions& options) {
  const LogFile log(options.log);
  const ReplayOutcome outcome = replay(log, vehicles, options.replay);
  print_results(outcome.results, options.json, outcome.failures.empty() ? nullptr : &outcome.failures);
  print_failures(outcome.failures, options.json);
  return code_with_damage(kProgram, outcome.damage, options.accept_damage, outcome.failures.empty() ? 0 : 1);
}

int check(const VehicleRegistry& vehicles, LogOptions& options) {
  const LogFile log(options.log);
  options.replay.must_compare = true;  // without a gate there is nothing else to check
  const ReplayOutcome outcome = replay(log, vehicles, options.replay);
  return end_check(kProgram, log, outcome, check_failures(log, outcome), options, options.json);
}

void add_run(Command& root, const VehicleRegistry& vehicles, std::function<int()>& chosen) {
  auto options = std::make_shared<RunOptions>();
  Command* command = root.add_subcommand("run", "Run the scene live, on devices or against a plant");
  add_live_options(*command, options->live);
  add_output(*command, options->json, options->quiet);
  command->callback(
      [&vehicles, &chosen, options] { chosen = [&vehicles, options] { return run(vehicles, *options); }; });
}

// Of `replay` and `check`.
std::shared_ptr<LogOptions> add_log_options(Command& command) {
  auto options = std::make_shared<LogOptions>();
  command.add_option("log", options->log, "LCM log from `run --record`")->required();
  add_scene_option(command, options->replay.scene);
  add_map_options(command, options->replay.maps);
  add_span_options(command, options->replay, false);
  add_threads_option(command, options->replay);
  add_fault_option(command, options->replay);
  add_acceptance_options(command, *options);
  add_output(command, options->json, options->quiet);
  return options;
}

void add_replay(Command& root, const VehicleRegistry& vehicles, std::function<int()>& chosen) {
  Command* command = root.add_subcommand("replay", "Run a log through the runtime again: timing, digest");
  const auto options = add_log_options(*command);
  command->add_option("--set", options->replay.overrides, "Override a key of the profile, key=value")
      ->take_all();
  add_record_option(*command, options->replay);
  command->callback([&vehicles, &chosen, options] {
    chosen = [&vehicles, options] { return replay_log(vehicles, *options); };
  });
}

void add_check(Command& root, const VehicleRegistry& vehicles, std::function<int()>& chosen) {
  Command* command =
      root.add_subcommand("check", "Replay a log and compare every output with what was recorded");
  const auto options = add_log_options(*command);
  command->callback(
      [&vehicles, &chosen, options] { chosen = [&vehicles, options] { return check(vehicles, *options); }; });
}

}  // namespace

void add_robot_commands(Command& root, const VehicleRegistry& vehicles, std::function<int()>& chosen) {
  add_run(root, vehicles, chosen);
  add_replay(root, vehicles, chosen);
  add_check(root, vehicles, chosen);
  add_doctor(root, chosen);
}

}  // namespace sortie::firmware
