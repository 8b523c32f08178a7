// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench odometry`: error of attitude and odometry against run time.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "toolchain/bench/odometry_bench.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/judge/alignment.hpp"

namespace sortie::toolchain {

namespace {

struct OdometryCommandLine {
  std::vector<std::string> logs;
  std::string log_scene;
  std::string align{"none"};
  double calibrate_s{};
  std::vector<std::string> scenes;
  int rounds{3};
  OutputOptions output;
};

/// Scenes with obstacles and how long they drive, s.
constexpr std::pair<const char*, double> kScenes[] = {
    {"ugv_pallet", 17}, {"ugv_ramp", 17}, {"ugv_stairs", 18}, {"ugv_mission", 165}};

std::vector<OdometrySet> read_sets(const CommandContext& context, const OdometryCommandLine& options) {
  std::vector<OdometrySet> sets;
  for (const std::string& path : options.logs) {
    const firmware::LogFile log(path);
    OdometrySet& set = sets.emplace_back(read_odometry_set(log, options.log_scene));
    set.name = std::filesystem::path(path).stem().string();
    set.evaluation.align = parse_alignment(options.align);
    set.evaluation.calibrate_s = options.calibrate_s;
    if (set.truth.empty())
      throw firmware::InputError(path + ": holds no truth; there is no error to measure", 2);
  }
  std::vector<std::string> wanted = options.scenes;
  if (wanted.empty() && options.logs.empty()) {
    for (const auto& [name, seconds] : kScenes) wanted.emplace_back(name);
  }
  for (const std::string& scene : wanted) {
    const auto* found = std::find_if(std::begin(kScenes), std::end(kScenes),
                                     [&](const auto& entry) { return scene == entry.first; });
    sets.push_back(drive_odometry_set(context.parts.vehicles, context.parts.simulator, scene,
                                      found != std::end(kScenes) ? found->second : 60.0));
  }
  return sets;
}

/// Thinnings that leave 50 Hz or more; a slower sensor is measured as it is.
std::vector<std::uint32_t> thinnings(double rate_hz) {
  std::vector<std::uint32_t> every{1};
  for (const std::uint32_t each : {2u, 5u, 10u, 20u}) {
    if (std::round(rate_hz / each) >= 50.0) every.push_back(each);
  }
  return every;
}

int run(const CommandContext& context, const OdometryCommandLine& options) {
  if (options.scenes.empty() && options.logs.empty() && !context.parts.simulator)
    throw firmware::InputError("this program simulates no robot; give a log with --log", 2);
  const auto progress = progress_bar(options.output, "bench");
  firmware::Json rows = firmware::Json::array();
  std::string page = "## Cells\n\nWritten by `" + context.command_line + "`.\n";
  const std::vector<OdometrySet> sets = read_sets(context, options);
  const std::string& folder = options.output.out;
  if (!folder.empty()) std::filesystem::create_directories(folder);
  double done = 0.0;
  for (const OdometrySet& set : sets) {
    const std::vector<OdometryCell> cells = measure_odometry(set, thinnings(set.rate_hz), options.rounds);
    for (const auto& row : to_json(cells)) rows.push_back(row);
    if (!options.output.json) print_odometry(std::cout, set, cells);
    page += "\n### " + set.name + "\n\n" + odometry_table(set, cells);
    if (!folder.empty()) {
      const std::string picture = "bench-odometry-" + set.name + ".svg";
      write_file(folder + "/" + picture, render(plot_odometry(set, cells)) + "\n");
      page += "\n![" + set.name + ": error over run time](" + picture + ")\n";
    }
    if (!folder.empty() && set.odometry.obstacles) {
      const std::string picture = "bench-odometry-" + set.name + "-height.svg";
      write_file(folder + "/" + picture, render(plot_heights(set)) + "\n");
      page += "\n![" + set.name + ": height along the way](" + picture + ")\n";
    }
    done += 1.0;
    if (progress) progress(done / static_cast<double>(sets.size()));
  }
  const firmware::Json result{{"command", context.command_line}, {"cells", rows}};
  if (options.output.json) show_json(result);
  if (folder.empty()) return 0;
  write_file(folder + "/bench-odometry.json", result.dump(2) + "\n");
  write_file(folder + "/bench-odometry-cells.md", page);
  std::cerr << "report: " << folder << "/bench-odometry*.{json,md,svg}\n";
  return 0;
}

}  // namespace

void add_bench_odometry(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<OdometryCommandLine>();
  firmware::Command* command = bench.add_subcommand(
      "odometry", "Attitude and odometry: error against run time over rate, precision and parts left out");
  command->footer(
      "Without a log: drives over the obstacles of the built-in scenes, judged by their height.\n"
      "Cost is processor time of the thread; rounds go by turns, the fastest counts.\n"
      "Examples:\n"
      "  sortie bench odometry --out out/odometry\n"
      "  sortie bench odometry --scene ugv_stairs --rounds 5\n"
      "  sortie bench odometry --log trial.lcm --log-scene imu_bench\n"
      "  sortie bench odometry --log husky.lcm --log-scene skid_outdoor --align se2 --calibrate-s 60");
  command->add_option("--log", options->logs, "Logs with truth to measure on")->type_name("LOG")->take_all();
  command->add_option("--log-scene", options->log_scene, "Scene of imported logs");
  add_alignment_option(*command, options->align);
  add_calibration_option(*command, options->calibrate_s,
                         "Of logs: the truth of the first seconds calibrates, the rest is judged");
  command->add_option("--scene", options->scenes, "Scenes to drive")->take_all();
  command->add_option("--rounds", options->rounds, "Rounds of what is timed")
      ->in_range(1, 1000)
      ->capture_default_str();
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the tables");
  command->add_flag("--quiet", options->output.quiet, "No progress bar");
  command->add_option("--out", options->output.out, "Folder for tables, JSON and pictures")->type_name("DIR");
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
