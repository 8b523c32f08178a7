// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>
#include <memory>
#include <optional>

#include "drivers/lcm_url.hpp"
#include "firmware_like/commands/commands.hpp"
#include "firmware_like/commands/gate.hpp"
#include "firmware_like/evaluation/alignment.hpp"
#include "firmware_like/live_run.hpp"
#include "firmware_like/program.hpp"
#include "firmware_like/report/html.hpp"
#include "firmware_like/runtime.hpp"
#include "firmware_like/stop_signals.hpp"

namespace sortie::firmware {

namespace {

struct RunOptions {
  LiveRunOptions live;
  OutputOptions output;
  std::string align{"none"};
  std::string gate;
};

int run(const CommandContext& context, RunOptions& options) {
  // First: a gate that cannot be used is told before anything moves.
  std::optional<Gate> gate;
  if (!options.gate.empty()) gate.emplace(options.gate);
  options.live.evaluation.align = parse_alignment(options.align);
  options.live.progress = progress_bar(options.output, "run");
  const StopSignals stop;  // up to the last word of the report
  options.live.interrupted = &StopSignals::asked();
  const LiveRunOutcome outcome = run_live(context.parts.vehicles, context.parts.bench, options.live);
  ReportInput report;
  report.results = outcome.results;
  report.command = context.command_line;
  report.source = outcome.bench;
  report.alignment = options.align;
  report.estimate =
      outcome.evaluation.pairs.estimate.empty() ? outcome.estimate : outcome.evaluation.pairs.estimate;
  report.truth = outcome.evaluation.pairs.truth;
  report.errors = outcome.evaluation.series;
  add_contact_plots(report, outcome.contacts);
  add_map_plot(report, *outcome.runtime, outcome.estimate);
  // What the gate asks for and the run did not measure is told after its results, which are there.
  std::vector<std::string> failures = outcome.failures;
  std::optional<ProfileError> unanswered;
  try {
    if (gate) {
      for (std::string& line : gate->judge(outcome.results)) failures.push_back(std::move(line));
    }
  } catch (const ProfileError& error) {
    unanswered = error;
  }
  show_results(options.output, report, (gate && !unanswered) || !failures.empty() ? &failures : nullptr);
  if (!outcome.flight_ring.empty()) std::cerr << "flight ring: " << outcome.flight_ring << "\n";
  if (!outcome.log.empty()) std::cerr << "log: " << outcome.log << "\n";
  if (!outcome.former_log.empty()) std::cerr << "the former log: " << outcome.former_log << "\n";
  if (unanswered) throw ProfileError(*unanswered);
  show_failures(options.output, failures);
  if (gate && failures.empty() && !options.output.json) std::cout << "passed  the gate\n";
  return outcome.stopped.empty() && failures.empty() ? 0 : 1;
}

}  // namespace

void add_run(Command& app, CommandContext& context) {
  auto options = std::make_shared<RunOptions>();
  options->live.lcm_url = std::string(drivers::kDefaultLcmUrl);
  Command* command = app.add_subcommand("run", "Run a scene live, against simulated or real devices");
  command->footer(
      "Examples:\n"
      "  sortie run --scene ugv_hall --seconds 20 --record hall.lcm\n"
      "  sortie run --scene ugv_hall --virtual --out out/hall\n"
      "  sortie run --scene ugv_hall --record hall.lcm --gate latency.toml   # exit 1: a bound is broken\n"
      "  sortie run --scene ugv_hall --plant own --record hall.lcm   # beside: sortie plant --scene "
      "ugv_hall\n"
      "  sortie run --scene ugv_hall --can can0 --require-rt");
  command->add_option("--scene", options->live.scene, "Scene by name, or a .toml file")->required();
  command->add_option("--set", options->live.overrides, "Override a key of the profile: key=value")
      ->take_all();
  command->add_option("--seconds", options->live.seconds, "How long")
      ->in_range(0.01, 1e7)
      ->capture_default_str();
  command->add_flag("--virtual", options->live.virtual_time,
                    "Simulated time, as fast as it goes; the same outputs every time");
  command->add_option("--record", options->live.record, "Write an LCM log that replays to the same digest")
      ->type_name("LOG");
  command->add_flag("--record-fields", options->live.record_fields,
                    "Put all outputs into the log, so that `check` can name a field");
  command->add_option("--lcm-url", options->live.lcm_url, "Where telemetry goes; none: off")
      ->capture_default_str();
  command
      ->add_option("--can", options->live.can_interface, "Real CAN interface instead of the simulated robot")
      ->type_name("IFACE");
  command
      ->add_option("--plant", options->live.plant,
                   "own, or own:PORT: against `sortie plant` in another process instead; with --can over CAN")
      ->type_name("WHERE");
  command->add_flag("--require-rt", options->live.require_realtime,
                    "Exit 4 when the platform refuses real-time scheduling");
  command->add_flag("!--no-rt", options->live.realtime, "Do not ask for real-time scheduling");
  command
      ->add_option("--flight-ring", options->live.flight_ring.path,
                   "Keep the last ticks in FILE, where a crash cannot take them; auto: in memory, none: not")
      ->type_name("FILE")
      ->capture_default_str();
  command
      ->add_option("--flight-ticks", options->live.flight_ring.ticks, "How many ticks the flight ring keeps")
      ->in_range(16, 10'000'000)
      ->capture_default_str();
  add_gate_option(*command, options->gate);
  add_alignment_option(*command, options->align);
  add_output_options(*command, options->output);
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
