// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/result/results.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/json.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/export/tum.hpp"
#include "toolchain/judge/fired_rays.hpp"
#include "toolchain/report/html.hpp"
#include "toolchain/report/map_plot.hpp"
#include "toolchain/sweep/sweep_set.hpp"

namespace sortie::toolchain {

void add_output_options(firmware::Command& command, OutputOptions& options) {
  command.add_flag("--json", options.json, "Print one JSON object instead of the table");
  command.add_flag("--quiet", options.quiet, "No progress bar");
  command.add_option("--out", options.out, "Folder for results.json, report.html and the trajectories")
      ->type_name("DIR");
}

void add_alignment_option(firmware::Command& command, std::string& alignment) {
  command.add_option("--align", alignment, "What may move before errors are taken")
      ->one_of({"none", "first", "se2", "se3"})
      ->capture_default_str();
}

void add_calibration_option(firmware::Command& command, double& calibrate_s, const std::string& about) {
  command.add_option("--calibrate-s", calibrate_s, about)->in_range(0.0, 1e6)->type_name("SECONDS");
}

void add_truth_option(firmware::Command& command, std::string& truth) {
  command
      .add_option("--truth", truth,
                  "Take the truth from this log of `plant --record`, not from the run's own")
      ->type_name("LOG");
}

void add_gate_option(firmware::Command& command, std::string& gate) {
  command.add_option("--gate", gate, "Bounds on errors, counters, pools and the robot's times: a TOML file")
      ->type_name("FILE");
}

void add_map_plot(ReportInput& report, const firmware::Runtime& runtime, const firmware::Trajectory& path) {
  const std::vector<MapPoint> points = map_points(runtime.vehicle());
  if (!points.empty()) report.more_plots.push_back(plot_map(points, path));
  Plot segments = plot_segments(points);
  if (!segments.series.empty()) report.more_plots.push_back(std::move(segments));
}

void add_ray_plot(ReportInput& report, const firmware::LogFile& log, const firmware::Runtime& runtime,
                  const firmware::Trajectory& path) {
  firmware::Profile profile(runtime.profile().canonical(), log.path());
  if (profile.vehicle() != "ugv" || log.channel(std::string(drivers::kChannelSsl)).empty()) return;
  const FiredRays fired = fired_rays(log, std::move(profile), path);
  if (!fired.rays.empty())
    report.more_plots.push_back(plot_fired_rays(fired, occupied_cells(runtime.vehicle()), path));
}

std::function<void(double)> progress_bar(const OutputOptions& options, const std::string& word) {
  if (options.quiet || ::isatty(STDERR_FILENO) == 0) return nullptr;
  return [word, last = -1](double share) mutable {
    const int percent = static_cast<int>(std::lround(100 * share));
    if (percent == last) return;
    last = percent;
    constexpr int kWidth = 40;
    const int filled = percent * kWidth / 100;
    std::fprintf(stderr, "\r%s [%s%s] %3d %%", word.c_str(),
                 std::string(static_cast<std::size_t>(filled), '#').c_str(),
                 std::string(static_cast<std::size_t>(kWidth - filled), ' ').c_str(), percent);
    if (percent >= 100) std::fputc('\n', stderr);
  };
}

void show_json(const firmware::Json& json) { std::cout << json.dump(2) << "\n"; }

void show_results(const OutputOptions& options, const ReportInput& report,
                  const std::vector<std::string>* judged) {
  firmware::print_results(report.results, options.json, judged);
  if (options.out.empty()) return;
  std::filesystem::create_directories(options.out);
  write_file(options.out + "/results.json", to_json(report.results).dump(2) + "\n");
  const auto write_trajectory = [&options](const char* name,
                                           const std::vector<firmware::TimedPose>& trajectory) {
    if (trajectory.empty()) return;
    write_file(options.out + name, [&trajectory](std::ostream& out) { write_tum(out, trajectory); });
  };
  write_trajectory("/trajectory.tum", report.estimate);
  write_trajectory("/located.tum", report.located);
  write_trajectory("/truth.tum", report.truth);
  const auto write_picture = [&options](const char* name, const Plot& plot) {
    if (!plot.series.empty()) write_file(options.out + name, render(plot));
  };
  write_picture("/recognised.svg", report.recognised.accepted);
  write_picture("/refused.svg", report.recognised.refused);
  write_file(options.out + "/report.html", render_report(report));
  std::cerr << "report: " << options.out << "/report.html\n";
}

void show_sweep_set(const CommandContext& context, const OutputOptions& options, const SweepSet& set) {
  firmware::Json object = to_json(set);
  object["command"] = context.command_line;
  if (options.json) {
    show_json(object);
  } else {
    print_sweep_set(std::cout, set, firmware::wants_colour(STDOUT_FILENO));
  }
  if (!options.out.empty()) write_sweep_set(options.out, set, object);
}

}  // namespace sortie::toolchain
