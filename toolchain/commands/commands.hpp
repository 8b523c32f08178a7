// SPDX-License-Identifier: BSD-3-Clause
// The commands of the command line. Each add_* function declares its options and what happens when it is
// chosen.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "firmware_like/log/timed_pose.hpp"
#include "firmware_like/scene/command_line.hpp"
#include "toolchain/commands/program_parts.hpp"

namespace sortie::firmware {
class Json;
class LogFile;
class Runtime;
}  // namespace sortie::firmware

namespace sortie::toolchain {

struct ReportInput;
struct SweepSet;

/// What all commands share.
struct CommandContext {
  const ProgramParts& parts;
  std::string command_line;       ///< as typed, for reports
  std::function<int()> chosen{};  ///< set by the command that was chosen; returns the exit code

  /// For the callback of a command: makes `command` the chosen one.
  std::function<void()> choose(std::function<int()> command) {
    return [this, command = std::move(command)] { chosen = command; };
  }
};

/// Options that every command with a result has.
struct OutputOptions {
  bool json{};
  bool quiet{};
  std::string out;  ///< folder for results.json, report.html, trajectories; empty: none
};

/// Adds --json, --quiet and --out to a command.
void add_output_options(firmware::Command& command, OutputOptions& options);
/// Adds --align.
void add_alignment_option(firmware::Command& command, std::string& alignment);

/// Adds --calibrate-s.
void add_calibration_option(
    firmware::Command& command, double& calibrate_s,
    const std::string& about =
        "The truth of the first seconds calibrates heading, gyro bias and wheel scale; "
        "errors are those of the rest, in place of --align");

/// Adds --truth: errors against the log of a plant that ran in a process of its own.
void add_truth_option(firmware::Command& command, std::string& truth);

/// A progress bar on stderr, if that is a terminal; otherwise null.
std::function<void(double)> progress_bar(const OutputOptions& options, const std::string& word);

/// Prints what --json asks for.
void show_json(const firmware::Json& json);
/// Prints the result (table or JSON), writes the folder, tells where the report is. `judged`: what made the
/// command fail, where something judged it; JSON then has `passed` and `failures`.
void show_results(const OutputOptions& options, const ReportInput& report,
                  const std::vector<std::string>* judged = nullptr);
/// Prints sweeps (tables or JSON) and writes the folder, if there is one.
void show_sweep_set(const CommandContext& context, const OutputOptions& options, const SweepSet& set);
/// Adds --gate.
void add_gate_option(firmware::Command& command, std::string& gate);

/// Adds a picture of the map, if there is one, with the path that was estimated, before any alignment.
void add_map_plot(ReportInput& report, const firmware::Runtime& runtime, const firmware::Trajectory& path);

/// Adds a picture of the rays that a solid-state lidar fired, if the log has any, over the occupancy map.
void add_ray_plot(ReportInput& report, const firmware::LogFile& log, const firmware::Runtime& runtime,
                  const firmware::Trajectory& path);

/// The commands of this program, each by its own function from here on.
void add_commands(firmware::Command& app, CommandContext& context);
void add_run(firmware::Command& app, CommandContext& context);
void add_plant(firmware::Command& app, CommandContext& context);
void add_replay(firmware::Command& app, CommandContext& context);
void add_check(firmware::Command& app, CommandContext& context);
void add_diff(firmware::Command& app, CommandContext& context);
void add_index(firmware::Command& app, CommandContext& context);
void add_import(firmware::Command& app, CommandContext& context);
void add_export(firmware::Command& app, CommandContext& context);
void add_report(firmware::Command& app, CommandContext& context);
void add_bench(firmware::Command& app, CommandContext& context);
void add_merge(firmware::Command& app, CommandContext& context);
void add_scenes(firmware::Command& app, CommandContext& context);
void add_spy(firmware::Command& app, CommandContext& context);
void add_set(firmware::Command& app, CommandContext& context);
void add_drive(firmware::Command& app, CommandContext& context);
void add_fly(firmware::Command& app, CommandContext& context);

/// `bench LOG... --sweep`: the options of `bench` itself.
void add_bench_sweep(firmware::Command& bench, CommandContext& context);
/// `bench all`: every part below, one after another.
void add_bench_all(firmware::Command& bench, CommandContext& context);
/// `bench rt`, `plant`, `mapping`, `registration`, `uav`, `stability`, `campaign`, `rays`: those that have
/// programs of their own.
void add_bench_peers(firmware::Command& bench, CommandContext& context);
/// `bench odometry`: attitude and odometry, error against run time.
void add_bench_odometry(firmware::Command& bench, CommandContext& context);
/// `bench wcet`: instructions of every job.
void add_bench_wcet(firmware::Command& bench, CommandContext& context);

}  // namespace sortie::toolchain
