// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench knobs`: what each knob of a scene's algorithms is worth.
#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/bench/knob_bench.hpp"
#include "toolchain/bench/temporary_log.hpp"
#include "toolchain/commands/bench_commands.hpp"
#include "toolchain/commands/sweep_drives.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/judge/alignment.hpp"
#include "toolchain/program/program.hpp"

namespace sortie::toolchain {

namespace {

struct KnobCommandLine {
  std::vector<std::string> logs;
  std::string log_scene;
  std::string align{"none"};
  double calibrate_s{};
  std::vector<std::string> scenes;
  double seconds{20};
  std::uint32_t repeat{2};
  std::vector<std::string> overrides;
  OutputOptions output;
};

std::vector<KnobSet> sets_of(const CommandContext& context, const KnobCommandLine& options,
                             const std::string& folder) {
  std::vector<KnobSet> sets;
  for (const std::string& path : options.logs) {
    KnobSet& set = sets.emplace_back();
    set.name = std::filesystem::path(path).stem().string();
    set.log = path;
    set.scene = options.log_scene.empty() ? firmware::LogFile(path).header().scene : options.log_scene;
    if (set.scene.empty())
      throw firmware::ProfileError(path + " was imported and names no scene; add --log-scene NAME");
    set.overrides = options.overrides;
    set.evaluation.align = parse_alignment(options.align);
    set.evaluation.calibrate_s = options.calibrate_s;
  }
  std::vector<std::string> scenes = options.scenes;
  if (scenes.empty() && options.logs.empty()) scenes = {"ugv_hall", "ugv_stairs", "uav_gusts"};
  for (const std::string& scene : scenes) {
    if (!context.parts.simulator)
      throw firmware::ProfileError("this program simulates no robot; give a log with --log");
    const std::vector<SimulatedDrive> drives =
        simulate_drives(context, {scene, options.overrides, options.seconds, 1}, folder + "/" + scene);
    sets.push_back({scene, drives.front().log, scene, options.overrides, {}});
  }
  return sets;
}

int run(const CommandContext& context, const KnobCommandLine& options) {
  const TemporaryFolder drives;
  const auto progress = progress_bar(options.output, "bench");
  const std::string& folder = options.output.out;
  if (!folder.empty()) std::filesystem::create_directories(folder);
  firmware::Json rows = firmware::Json::array();
  std::string page =
      "# Every knob alone\n\nWritten by `" + context.command_line +
      "`. One recording a section, replayed with one key of the profile at other values: a number "
      "at a quarter, half, twice and four times, a choice at all it may be. `<` is what the "
      "profile says, `*` what no other value is as cheap and better than. Errors repeat "
      "to the bit; load is processor time of the knob's tasks per second of the robot's time, and "
      "moves with the machine. Where a knob is not the map's, the replay has no map; the pictures leave the "
      "map out, whose error is of another kind.\n\n```\n" +
      firmware::machine_description() + "; " + firmware::compiler_description() + "\n```\n";
  const std::vector<KnobSet> sets = sets_of(context, options, drives.file("drives"));
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const auto share = [&](double done) {
      if (progress) progress((static_cast<double>(i) + done) / static_cast<double>(sets.size()));
    };
    const std::vector<KnobSweep> sweeps = sweep_knobs(sets[i], context.parts.vehicles, options.repeat, share);
    for (const auto& row : to_json(sets[i].name, sweeps)) rows.push_back(row);
    if (!options.output.json) print_knobs(std::cout, sets[i].name, sweeps);
    const std::string picture = "bench-knobs-" + sets[i].name + ".svg";
    page += "\n## " + sets[i].name + "\n\n![" + sets[i].name + ": error over run time](" + picture + ")\n\n" +
            knob_table(sweeps);
    if (!folder.empty()) {
      write_file(folder + "/" + picture,
                 [&](std::ostream& out) { out << render(plot_knobs(sets[i].name, sweeps)) << "\n"; });
    }
  }
  const firmware::Json result{{"command", context.command_line}, {"cells", rows}};
  if (options.output.json) std::cout << result.dump(2) << "\n";
  if (folder.empty()) return 0;
  write_file(folder + "/bench-knobs.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
  write_file(folder + "/bench-knobs.md", [&](std::ostream& out) { out << page; });
  std::cerr << "report: " << folder << "/bench-knobs*.{json,md,svg}\n";
  return 0;
}

}  // namespace

void add_bench_knobs(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<KnobCommandLine>();
  firmware::Command* command = bench.add_subcommand(
      "knobs", "Every knob of a scene's estimators and map, one at a time: error against run time");
  command->footer(
      "Without a log: drives of ugv_hall, ugv_stairs and uav_gusts. Marks: * no other value is as cheap and "
      "better, < what the profile says.\n"
      "Examples:\n"
      "  sortie bench knobs --out out/knobs\n"
      "  sortie bench knobs --scene ugv_pallet --seconds 17\n"
      "  sortie bench knobs --log husky.lcm --log-scene skid_outdoor --align se2 --calibrate-s 60");
  command->add_option("--log", options->logs, "Logs with truth to measure on")->type_name("LOG")->take_all();
  command->add_option("--log-scene", options->log_scene, "Scene of imported logs");
  add_alignment_option(*command, options->align);
  command
      ->add_option("--calibrate-s", options->calibrate_s,
                   "Of logs: the truth of the first seconds calibrates, the rest is judged")
      ->in_range(0.0, 1e6)
      ->type_name("SECONDS");
  command->add_option("--scene", options->scenes, "Scenes to drive")->take_all();
  command->add_option("--seconds", options->seconds, "Length of each drive")
      ->in_range(0.1, 100000.0)
      ->capture_default_str();
  command->add_option("--repeat", options->repeat, "Replays of every cell; each job's shortest counts")
      ->in_range(1, 1000)
      ->capture_default_str();
  command->add_option("--set", options->overrides, "Override a key in all cells: key=value")->take_all();
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the tables");
  command->add_flag("--quiet", options->output.quiet, "No progress bar");
  command->add_option("--out", options->output.out, "Folder for table, JSON and pictures")->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::toolchain
