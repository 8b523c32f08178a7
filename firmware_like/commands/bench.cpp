// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "firmware_like/bench/sweep_report.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/importers/input_error.hpp"

namespace sortie::firmware {

namespace {

struct BenchOptions {
  std::string log;
  std::vector<std::string> knobs;
  std::string align{"none"};
  bool accept_damage{};
  SweepOptions sweep;
  OutputOptions output;
};

int run(const CommandContext& context, BenchOptions& options) {
  options.sweep.knobs = parse_knobs(options.knobs);
  options.sweep.replay.evaluation.align = parse_alignment(options.align);
  options.sweep.progress = progress_bar(options.output, "bench");
  const LogFile log(options.log);
  Sweep sweep = run_sweep(log, context.parts.vehicles, options.sweep);
  for (const std::string& problem : log.problems()) sweep.warnings.push_back(problem);
  nlohmann::ordered_json object = to_json(sweep);
  object["log"] = options.log;
  object["command"] = context.command_line;
  if (options.output.json) {
    std::cout << object.dump(2) << "\n";
  } else {
    print_sweep(std::cout, sweep, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/sweep.json", [&object](std::ostream& out) { out << object.dump(2) << "\n"; });
    write_file(folder + "/sweep.csv", [&sweep](std::ostream& out) { write_sweep_csv(out, sweep); });
    write_file(folder + "/sweep.svg", [&sweep](std::ostream& out) { out << render(plot_sweep(sweep)); });
    std::cerr << "sweep: " << folder << "/sweep.{csv,json,svg}\n";
  }
  return finish_with_log(context, log, options.accept_damage, 0);
}

}  // namespace

void add_bench(CLI::App& app, CommandContext& context) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command = app.add_subcommand("bench",
                                         "Measure: sweep a profile's keys over a log; rt: the real-time "
                                         "ground; plant: the tracked plant; rays: the ray scheduler; uav: "
                                         "the multirotor; odometry: attitude and odometry; wcet: "
                                         "instructions of every job");
  command->footer(
      "Marks: * no other cell is as cheap and better, < what the profile says by itself.\n"
      "Examples:\n"
      "  sortie bench walk.lcm --scene building_walk --sweep map.voxel_m=0.05,0.1,0.2\n"
      "  sortie bench husky.lcm --scene skid_outdoor --align se2 --sweep groups.control.rate_hz=50,100,200 "
      "\\\n"
      "    --sweep attitude.acc_time_constant_s=2,3,4 --repeat 5 --out out/husky");
  CLI::Option* log = command->add_option("log,--log", options->log, "LCM log from `run --record` or `import`")
                         ->type_name("LOG");
  CLI::Option* sweep =
      command->add_option("--sweep", options->knobs, "Key of the profile and its values: key=v1,v2,v3");
  sweep->take_all()->delimiter('\n');
  command->add_option("--scene", options->sweep.replay.scene,
                      "Another scene than the log's own; needed for imported logs");
  command->add_option("--set", options->sweep.replay.overrides, "Override a key in all cells: key=value")
      ->take_all();
  command->add_option("--repeat", options->sweep.repeat, "Replays of every cell")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--task", options->sweep.tasks,
                   "Whose run time counts, if not that of the tasks the keys belong to")
      ->take_all();
  command->add_option("--error", options->sweep.error, "Which error counts, as named in `replay --json`");
  add_alignment_option(*command, options->align);
  add_damage_option(*command, options->accept_damage);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_flag("--quiet", options->output.quiet, "No progress bar");
  command->add_option("--out", options->output.out, "Folder for sweep.csv, sweep.json and sweep.svg")
      ->type_name("DIR");
  command->require_subcommand(0, 1);
  add_bench_rt(*command, context);
  add_bench_plant(*command, context);
  add_bench_mapping(*command, context);
  add_bench_rays(*command, context);
  add_bench_uav(*command, context);
  add_bench_odometry(*command, context);
  add_bench_stability(*command, context);
  add_bench_wcet(*command, context);
  command->callback([&context, options, command, log, sweep] {
    if (!command->get_subcommands().empty()) return;
    if (log->count() == 0) throw CLI::RequiredError(log->get_name());
    if (sweep->count() == 0) throw CLI::RequiredError(sweep->get_name());
    context.chosen = [&context, options] { return run(context, *options); };
  });
}

}  // namespace sortie::firmware
