// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/json_reader.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/replay_report.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/sweep/sweep_report.hpp"

namespace sortie::toolchain {

namespace {

struct PageOptions {
  std::vector<std::string> logs;
  std::vector<std::string> knobs;  // "key=v1,v2,v3" each
  std::string sweep_to;            // time or @tick; empty: as far as the page's replay
  ReplayReportOptions replay;
  OutputOptions output;
};

// Sweeps each knob by itself over every log whose scene knows the key; an entry a log. Throws ProfileError
// where no log's scene can be swept so.
std::vector<std::vector<Sweep>> sweep_logs(const CommandContext& context, const PageOptions& options) {
  std::vector<std::vector<Sweep>> sweeps(options.logs.size());
  SweepOptions sweep;
  sweep.replay = options.replay.replay;
  sweep.replay.on_job = nullptr;
  if (!options.sweep_to.empty()) sweep.replay.to = options.sweep_to;
  sweep.evaluation = options.replay.evaluation;
  sweep.evaluation.align = parse_alignment(options.replay.align);
  for (const std::string& text : options.knobs) {
    sweep.knobs = parse_knobs({text});
    std::exception_ptr refusal;
    bool swept = false;
    for (std::size_t i = 0; i < options.logs.size(); ++i) {
      sweep.progress = progress_bar(options.output, "sweep");
      try {
        sweeps[i].push_back(run_sweep(firmware::LogFile(options.logs[i]), context.parts.vehicles, sweep));
        swept = true;
      } catch (const firmware::ProfileError&) {
        // Another robot's key; an error only where no log's scene takes it.
        refusal = std::current_exception();
      }
    }
    if (!swept && refusal) std::rethrow_exception(refusal);
  }
  return sweeps;
}

void write_sweeps(const PageOptions& options, const std::vector<std::vector<Sweep>>& sweeps) {
  firmware::Json all = firmware::Json::array();
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    for (const Sweep& sweep : sweeps[i]) {
      firmware::Json entry = to_json(sweep);
      entry["log"] = options.logs[i];
      all.push_back(std::move(entry));
    }
  }
  write_file(options.output.out + "/sweeps.json", firmware::Json{{"sweeps", all}}.dump(2) + "\n");
}

// Several logs on one page; their results in one file, in the order of the logs.
void show_all(const PageOptions& options, const std::vector<ReportInput>& reports, const Plot& ground) {
  firmware::Json runs = firmware::Json::array();
  for (const ReportInput& report : reports) {
    firmware::print_table(std::cout, report.results, firmware::wants_colour(STDOUT_FILENO));
    runs.push_back(to_json(report.results));
  }
  std::filesystem::create_directories(options.output.out);
  write_file(options.output.out + "/results.json", firmware::Json{{"runs", runs}}.dump(2) + "\n");
  const std::string page = options.output.out + "/report.html";
  write_file(page, render_report(reports, ground));
  std::cerr << "report: " << page << "\n";
}

int write_page(const CommandContext& context, PageOptions& options) {
  std::vector<ReportInput> reports;
  Plot ground;
  std::string damage;
  std::vector<std::string> failures;
  for (const std::string& log : options.logs) {
    ReplayedLog replayed = replay_for_report(context, options.replay, options.output, log);
    if (ground.series.empty()) ground = std::move(replayed.ground);
    if (damage.empty()) damage = replayed.damage;
    for (const std::string& failure : replayed.failures) failures.push_back(log + ": " + failure);
    reports.push_back(std::move(replayed.report));
  }
  const std::vector<std::vector<Sweep>> sweeps = sweep_logs(context, options);
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    for (const Sweep& sweep : sweeps[i]) reports[i].sweeps.push_back(sweep_figures(sweep));
  }
  if (reports.size() == 1) {
    show_results(options.output, reports.front());
  } else {
    show_all(options, reports, ground);
  }
  if (!options.knobs.empty()) write_sweeps(options, sweeps);
  for (const auto& of_log : sweeps) {
    for (const Sweep& sweep : of_log) print_sweep(std::cout, sweep, firmware::wants_colour(STDOUT_FILENO));
  }
  firmware::print_failures(failures, options.output.json);
  return firmware::code_with_damage(context.parts.name, damage, options.replay.accept_damage,
                                    failures.empty() ? 0 : 1);
}

}  // namespace

void add_report(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<PageOptions>();
  options->output.out = "report";
  firmware::Command* command =
      app.add_subcommand("report", "Replay logs and write one page about them: report.html");
  command->footer(
      "Examples:\n"
      "  sortie report hall.lcm --out out/hall\n"
      "  sortie report husky.lcm --scene skid_outdoor --align se2 --out out/husky\n"
      "  sortie report ugv.lcm uav.lcm --out out/mission --sweep map.voxel_m=0.05,0.1,0.2");
  command->add_option("logs", options->logs, "LCM logs from `run --record` or `import`")
      ->required()
      ->type_name("LOG");
  add_replay_report_options(*command, options->replay);
  command
      ->add_option(
          "--sweep", options->knobs,
          "Error over run time of a key of the profile, too, over every log that knows it: key=v1,v2,v3")
      ->take_all();
  command
      ->add_option("--sweep-to", options->sweep_to,
                   "End sweeps before that time or @tick of their log; default: --to")
      ->type_name("TIME");
  command->add_option("--out", options->output.out, "Folder")->type_name("DIR")->capture_default_str();
  command->callback(context.choose([&context, options] { return write_page(context, *options); }));
}

}  // namespace sortie::toolchain
