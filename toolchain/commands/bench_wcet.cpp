// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench wcet`: the exact worst case of every task over a log or a simulated drive.
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "firmware_like/live/live_run.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/scene/json.hpp"
#include "toolchain/bench/temporary_log.hpp"
#include "toolchain/bench/wcet_report.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/sweep/sweep_folder.hpp"

namespace sortie::toolchain {

namespace {

struct WcetCommand {
  WcetOptions count;
  OutputOptions output;
  double seconds{5};
  std::string expect;
  std::string counted;  ///< the counted program's own option
};

void record_drive(const CommandContext& context, const WcetCommand& options, const std::string& log) {
  firmware::LiveRunOptions run;
  run.scene = options.count.scene;
  run.overrides = options.count.overrides;
  run.maps = options.count.maps;
  run.seconds = options.seconds;
  run.virtual_time = true;
  run.lcm_url = "none";
  run.record = log;
  static_cast<void>(firmware::run_live(context.parts.vehicles, context.parts.simulator, run));
}

int judge(const Wcet& wcet, const std::string& path) {
  const WcetVerdict verdict = compare_wcet(wcet, whole_file(path, "--out DIR writes DIR/wcet.txt"), path);
  if (!verdict.skipped.empty()) {
    std::cerr << "skipped: " << path << " is not compared: " << verdict.skipped << "\n";
    return 0;
  }
  for (const std::string& failure : verdict.failures)
    std::cerr << "FAILED  " << path << ": " << failure << "\n";
  return verdict.failures.empty() ? 0 : 1;
}

int run(const CommandContext& context, WcetCommand& options) {
  if (!options.counted.empty()) {
    replay_counted(context.parts.vehicles, options.count, options.counted);
    return 0;
  }
  std::optional<TemporaryFolder> folder;  // of the simulated drive
  if (options.count.log.empty()) {
    options.count.log = folder.emplace("sortie-wcet").file("drive.lcm");
    record_drive(context, options, options.count.log);
    options.count.scene.clear();  // the log holds the profile, overrides included
    options.count.overrides.clear();
  }
  const Wcet wcet = measure_wcet(options.count);
  if (options.output.json) {
    show_json(to_json(wcet));
  } else {
    print_wcet(std::cout, wcet);
  }
  if (const std::string& out = options.output.out; !out.empty()) {
    std::filesystem::create_directories(out);
    write_file(out + "/wcet.json", to_json(wcet).dump(2) + "\n");
    write_file(out + "/wcet.csv", [&](std::ostream& csv) { write_wcet_csv(csv, wcet); });
    write_file(out + "/wcet.txt", gate_text(wcet, "scene " + wcet.scene));
    std::cerr << "counts: " << out << "/wcet.{txt,csv,json}\n";
  }
  return options.expect.empty() ? 0 : judge(wcet, options.expect);
}

}  // namespace

void add_bench_wcet(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<WcetCommand>();
  firmware::Command* command = bench.add_subcommand(
      "wcet", "Worst case of every task in instructions, exact: a replay counted by callgrind");
  command->footer(
      "The same program over the same log gives the same counts, to the instruction, on every machine of its "
      "kind.\n"
      "Examples:\n"
      "  sortie bench wcet hall.lcm\n"
      "  sortie bench wcet --scene ugv_hall --seconds 5 --out out/wcet\n"
      "  sortie bench wcet hall.lcm --expect tests/wcet.txt");
  auto* log = command->add_option("log,--log", options->count.log, "LCM log from `run --record` or `import`")
                  ->type_name("LOG");
  auto* scene =
      command->add_option("--scene", options->count.scene,
                          "Without a log: simulate this scene first; with one: another scene than the log's");
  command->add_option("--seconds", options->seconds, "How long to simulate")
      ->in_range(0.01, 1e5)
      ->excludes(log)
      ->capture_default_str();
  add_map_options(*command, options->count.maps);
  command->add_option("--set", options->count.overrides, "Override a key of the profile: key=value")
      ->take_all();
  command
      ->add_option("--expect", options->expect,
                   "Compare with a wcet.txt of --out: exit code 1 where it differs")
      ->type_name("FILE");
  command->add_option("--fault", options->count.fault,
                      "Loop a while within one job, task@tick: proves that a comparison can fail");
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for wcet.txt, wcet.csv and wcet.json")
      ->type_name("DIR");
  command->add_option("--counted", options->counted)->group("");
  command->callback([&context, options, log, scene] {
    if (log->count() == 0 && scene->count() == 0) firmware::Command::lacks("LOG or --scene SCENE");
    context.chosen = [&context, options] { return run(context, *options); };
  });
}

}  // namespace sortie::toolchain
