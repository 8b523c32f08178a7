// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>

#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/judge/gate.hpp"

namespace sortie::toolchain {

namespace {

struct CheckOptions : firmware::ReplayCommand {
  std::string gate;
  std::string align{"none"};
  OutputOptions output;
};

int run(const CommandContext& context, CheckOptions& options) {
  // First: a gate that cannot be used is told before the replay, not after it.
  std::optional<Gate> gate;
  if (!options.gate.empty()) gate.emplace(options.gate);
  const firmware::LogFile log(options.log);
  if (!log.header().has_ticks && options.gate.empty()) {
    throw firmware::InputError(
        options.log +
            ": an imported log holds no outputs to compare with; give --gate FILE, or record "
            "with `sortie run --record` or `sortie replay --record`",
        2);
  }
  options.replay.must_compare = log.header().has_ticks;
  options.replay.progress = progress_bar(options.output, "check");
  EvaluationOptions judging;
  judging.align = parse_alignment(options.align);
  firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, options.replay);
  judge(outcome, judging);

  std::vector<std::string> failures = firmware::check_failures(log, outcome);
  if (gate) {
    for (std::string& line : gate->judge(outcome.results)) failures.push_back(std::move(line));
  }
  return firmware::end_check(context.parts.name, log, outcome, failures, options, options.output.json);
}

}  // namespace

void add_check(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<CheckOptions>();
  firmware::Command* command =
      app.add_subcommand("check", "Replay a log and compare every output with what was recorded");
  command->footer(
      "Examples:\n"
      "  sortie check hall.lcm\n"
      "  sortie check hall.lcm --gate release.toml\n"
      "  sortie check husky.lcm --scene skid_outdoor --gate errors.toml   # imported: the gate alone\n"
      "  sortie check hall.lcm --from 60 --to 70       # after `sortie index hall.lcm`: in a moment\n"
      "  sortie check hall.lcm --fault odometry@1200   # shows that the check can fail");
  command->add_option("log", options->log, "LCM log with ticks")->required();
  add_gate_option(*command, options->gate);
  command->add_option("--scene", options->replay.scene, "The scene of an imported log, which names none");
  add_fault_option(*command, options->replay);
  command->add_flag("--threads", options->replay.threaded, "One worker a group");
  add_truth_option(*command, options->replay.truth);
  add_map_options(*command, options->replay.maps);
  add_span_options(*command, options->replay, true);
  add_alignment_option(*command, options->align);
  add_acceptance_options(*command, *options);
  command->add_flag("--json", options->output.json, "Print one JSON object");
  command->add_flag("--quiet", options->output.quiet, "No progress bar");
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
