// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <optional>

#include "firmware_like/log/replay.hpp"
#include "firmware_like/log/replay_verdict.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/judge/gate.hpp"
#include "toolchain/program/program.hpp"

namespace sortie::toolchain {

namespace {

struct CheckOptions {
  std::string log;
  std::string fault;
  std::string gate;
  std::string scene;
  std::string align{"none"};
  bool threaded{};
  std::string truth;
  SpanOptions span;
  bool accept_damage{};
  bool accept_unused{};
  OutputOptions output;
};

int run(const CommandContext& context, const CheckOptions& options) {
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
  firmware::ReplayOptions replay_options;
  replay_options.scene = options.scene;
  replay_options.threaded = options.threaded;
  replay_options.accept_unused = options.accept_unused;
  replay_options.must_compare = log.header().has_ticks;
  replay_options.fault = options.fault;
  replay_options.from = options.span.from;
  replay_options.to = options.span.to;
  replay_options.keyframes = options.span.keyframes;
  replay_options.truth = options.truth;
  EvaluationOptions judging;
  judging.align = parse_alignment(options.align);
  replay_options.progress = progress_bar(options.output, "check");
  firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, replay_options);
  judge(outcome, judging);

  std::vector<std::string> failures = firmware::check_failures(log, outcome);
  if (gate) {
    for (std::string& line : gate->judge(outcome.results)) failures.push_back(std::move(line));
  }

  const bool is_part = !options.span.from.empty() || !options.span.to.empty();
  firmware::print_check(log, outcome, failures, is_part, options.output.json);
  return finish_with_damage(context, outcome.damage, options.accept_damage, failures.empty() ? 0 : 1);
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
  command->add_option("--scene", options->scene, "The scene of an imported log, which names none");
  command->add_option("--fault", options->fault,
                      "Flip a bit of a task's output: task@tick or task.byte@tick");
  command->add_flag("--threads", options->threaded, "One worker a group");
  add_truth_option(*command, options->truth);
  add_span_options(*command, options->span);
  add_alignment_option(*command, options->align);
  add_unused_option(*command, options->accept_unused);
  add_damage_option(*command, options->accept_damage);
  command->add_flag("--json", options->output.json, "Print one JSON object");
  command->add_flag("--quiet", options->output.quiet, "No progress bar");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::toolchain
