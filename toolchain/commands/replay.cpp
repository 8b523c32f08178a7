// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <mutex>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/commands/replay_report.hpp"
#include "toolchain/judge/alignment.hpp"
#include "toolchain/report/map_plot.hpp"
#include "toolchain/report/plots.hpp"

namespace sortie::toolchain {

namespace {

// Of every task, so that they are not taken for those of the replay, which the table of tasks shows.
std::vector<FigureRow> live_rows(const firmware::Results& results) {
  std::vector<FigureRow> rows;
  for (const firmware::LiveTask& task : results.live.tasks) {
    rows.push_back({task.name + ", p50", firmware::format_short(task.p50_us), "us"});
    rows.push_back({task.name + ", p99", firmware::format_short(task.p99_us), "us"});
    rows.push_back({task.name + ", max", firmware::format_short(task.max_us), "us"});
  }
  return rows;
}

}  // namespace

void add_replay_report_options(firmware::Command& command, ReplayReportOptions& options) {
  add_scene_option(command, options.replay.scene);
  command.add_option("--set", options.replay.overrides, "What if: override a key of the profile, key=value")
      ->take_all();
  add_truth_option(command, options.replay.truth);
  add_map_options(command, options.replay.maps);
  add_span_options(command, options.replay, true);
  add_alignment_option(command, options.align);
  add_calibration_option(command, options.evaluation.calibrate_s);
  add_acceptance_options(command, options);
}

ReplayedLog replay_for_report(const CommandContext& context, ReplayReportOptions& options,
                              const OutputOptions& output, const std::string& path) {
  const firmware::LogFile log(path);
  options.evaluation.align = parse_alignment(options.align);
  options.replay.progress = progress_bar(output, "replay");
  RayFigures figures;
  JobTimeline timeline;
  RecognisedPlaces recognised;
  std::mutex one_at_a_time;  // with --threads each group has a thread
  options.replay.on_job = [&](const rt::JobRecord& record, firmware::Runtime& runtime) {
    const std::lock_guard guard(one_at_a_time);
    figures.job(record, runtime);
    timeline.job(record, runtime);
    recognised.job(record, runtime);
  };
  firmware::ReplayOutcome outcome = firmware::replay(log, context.parts.vehicles, options.replay);
  Evaluation evaluation = judge(outcome, options.evaluation);
  ReplayedLog replayed;
  ReportInput& report = replayed.report;
  report.results = std::move(outcome.results);
  report.command = context.command_line;
  report.source = path;
  report.alignment = options.align;
  report.timeline = plot_timeline(timeline);
  report.recognised = report_of(recognised, outcome.estimate);
  report.tables.push_back({"Run times on the robot", live_rows(report.results)});
  report.more_plots = plot_contacts(outcome.contacts);
  add_map_plot(report, *outcome.runtime, outcome.estimate);
  add_ray_plot(report, log, *outcome.runtime, outcome.estimate);
  report.tables.push_back({"Solid-state lidar", figures.rows(outcome.first_tick)});
  add_paths(report, outcome, evaluation);
  replayed.ground = plot_map(map_points(outcome.runtime->vehicle()), {});
  replayed.damage = outcome.damage;
  replayed.failures = outcome.failures;
  return replayed;
}

namespace {

int replay_and_show(const CommandContext& context, ReplayReportOptions& options,
                    const OutputOptions& output) {
  const ReplayedLog replayed = replay_for_report(context, options, output, options.log);
  show_results(output, replayed.report, replayed.failures.empty() ? nullptr : &replayed.failures);
  firmware::print_failures(replayed.failures, output.json);
  return firmware::code_with_damage(context.parts.name, replayed.damage, options.accept_damage,
                                    replayed.failures.empty() ? 0 : 1);
}

}  // namespace

void add_replay(firmware::Command& app, CommandContext& context) {
  struct Options {
    ReplayReportOptions replay;
    OutputOptions output;
  };
  auto options = std::make_shared<Options>();
  firmware::Command* command =
      app.add_subcommand("replay", "Run a log through the runtime again: errors, timing, digest");
  command->footer(
      "Examples:\n"
      "  sortie replay hall.lcm\n"
      "  sortie replay husky.lcm --scene skid_outdoor --align se2 --json\n"
      "  sortie replay drive.lcm --truth plant.lcm\n"
      "  sortie replay hall.lcm --from 60 --to 70\n"
      "  sortie replay again.lcm --map hall.surfels   # recorded with that map\n"
      "  sortie replay hall.lcm --set map.voxel_m=0.2 --out out/what-if");
  command->add_option("log", options->replay.log, "LCM log from `run --record` or `import`")->required();
  add_replay_report_options(*command, options->replay);
  add_record_option(*command, options->replay.replay);
  add_threads_option(*command, options->replay.replay);
  add_fault_option(*command, options->replay.replay);
  add_output_options(*command, options->output);
  command->callback(context.choose(
      [&context, options] { return replay_and_show(context, options->replay, options->output); }));
}

}  // namespace sortie::toolchain
