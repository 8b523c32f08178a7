// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>
#include <memory>
#include <optional>

#include "firmware_like/live/live_options.hpp"
#include "firmware_like/live/stop_signals.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/judge/evaluate.hpp"
#include "toolchain/judge/gate.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/plots.hpp"

namespace sortie::toolchain {

namespace {

struct RunOptions {
  firmware::LiveRunOptions live;
  OutputOptions output;
  std::string align{"none"};
  std::string gate;
};

int run(const CommandContext& context, RunOptions& options) {
  // First: a gate that cannot be used is told before anything moves.
  std::optional<Gate> gate;
  if (!options.gate.empty()) gate.emplace(options.gate);
  EvaluationOptions judging;
  judging.align = parse_alignment(options.align);
  options.live.progress = progress_bar(options.output, "run");
  const firmware::StopSignals stop;  // up to the last word of the report
  options.live.interrupted = &firmware::StopSignals::asked();
  firmware::LiveRunOutcome outcome =
      firmware::run_live(context.parts.vehicles, context.parts.simulator, options.live);
  Evaluation evaluation = judge(outcome, judging);
  ReportInput report;
  report.results = outcome.results;
  report.command = context.command_line;
  report.source = outcome.robot;
  report.alignment = options.align;
  report.more_plots = plot_contacts(outcome.contacts);
  add_map_plot(report, *outcome.runtime, outcome.estimate);
  add_paths(report, outcome, evaluation);
  // What the gate asks for and the run did not measure is told after its results, which are there.
  std::vector<std::string> failures = outcome.failures;
  std::optional<firmware::ProfileError> unanswered;
  try {
    if (gate) {
      for (std::string& line : gate->judge(outcome.results)) failures.push_back(std::move(line));
    }
  } catch (const firmware::ProfileError& error) {
    unanswered = error;
  }
  show_results(options.output, report, (gate && !unanswered) || !failures.empty() ? &failures : nullptr);
  firmware::tell_files(outcome);
  if (unanswered) throw firmware::ProfileError(*unanswered);
  firmware::print_failures(failures, options.output.json);
  if (gate && failures.empty() && !options.output.json) std::cout << "passed  the gate\n";
  return outcome.stopped.empty() && failures.empty() ? 0 : 1;
}

}  // namespace

void add_run(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<RunOptions>();
  firmware::Command* command =
      app.add_subcommand("run", "Run a scene live, against simulated or real devices");
  command->footer(
      "Examples:\n"
      "  sortie run --scene ugv_hall --seconds 20 --record hall.lcm\n"
      "  sortie run --scene ugv_hall --virtual --out out/hall\n"
      "  sortie run --scene ugv_hall --record hall.lcm --gate latency.toml   # exit 1: a bound is broken\n"
      "  sortie run --scene ugv_hall --plant own --record hall.lcm   # beside: sortie plant --scene "
      "ugv_hall\n"
      "  sortie run --scene ugv_locate --map hall.surfels   # of `sortie export surfels`\n"
      "  sortie run --scene ugv_hall --can can0 --require-rt");
  firmware::add_live_options(*command, options->live);
  add_gate_option(*command, options->gate);
  add_alignment_option(*command, options->align);
  add_output_options(*command, options->output);
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
