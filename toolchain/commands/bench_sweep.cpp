// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench LOG... --sweep`: error against run time over the knobs of a profile.
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "firmware_like/log/log_file.hpp"
#include "firmware_like/log/replay_command.hpp"
#include "firmware_like/scene/input_error.hpp"
#include "firmware_like/scene/profile.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/bench/temporary_log.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/commands/sweep_drives.hpp"
#include "toolchain/export/output_file.hpp"
#include "toolchain/sweep/sweep_jobs.hpp"
#include "toolchain/sweep/sweep_set.hpp"
#include "toolchain/sweep/sweep_slurm.hpp"

namespace sortie::toolchain {

namespace {

namespace fs = std::filesystem;

struct SweepCommand {
  SweepRequest request;
  DriveRequest drives;
  bool accept_damage{};
  std::size_t jobs{};  // 0: in this process
  std::string shard;
  std::string slurm;
  std::string cells;
  OutputOptions output;
  std::string damage;                        // of the first log that has any
  std::optional<TemporaryFolder> temporary;  // of drives that nobody keeps

  bool in_folder() const { return jobs != 0 || !shard.empty() || !slurm.empty(); }
};

[[noreturn]] void refuse(const std::string& why) { throw firmware::ProfileError(why); }

std::size_t whole(const std::string& text, const std::string& cure) {
  if (text.empty() || text.size() > 9 || text.find_first_not_of("0123456789") != std::string::npos)
    refuse(cure);
  return std::stoul(text);
}

// "2/5" as its two numbers; everything is a shard of 1.
std::pair<std::size_t, std::size_t> parse_shard(const std::string& text) {
  if (text.empty()) return {1, 1};
  const std::string cure = "--shard " + text + ": write i/n with 1 <= i <= n, for example --shard 2/5";
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) refuse(cure);
  const std::size_t i = whole(text.substr(0, slash), cure);
  const std::size_t n = whole(text.substr(slash + 1), cure);
  if (i < 1 || i > n) refuse(cure);
  return {i, n};
}

// "0,3-7" as numbers.
std::vector<std::size_t> parse_cells(const std::string& text) {
  const std::string cure = "--cell " + text + ": write numbers and ranges, for example --cell 0,3-7";
  std::vector<std::size_t> cells;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t end = std::min(text.find(',', from), text.size());
    const std::string part = text.substr(from, end - from);
    const std::size_t dash = part.find('-');
    const std::size_t first = whole(part.substr(0, dash), cure);
    const std::size_t last = dash == std::string::npos ? first : whole(part.substr(dash + 1), cure);
    if (last < first || last - first > 100000) refuse(cure);
    for (std::size_t cell = first; cell <= last; ++cell) cells.push_back(cell);
    from = end + 1;
  }
  return cells;
}

// Logs that the command names, with the scene that it gives them, or drives that are simulated now; then they
// hold the profile, overrides included.
std::vector<SimulatedDrive> take_drives(const CommandContext& context, SweepCommand& command) {
  SweepRequest& request = command.request;
  const std::vector<std::string>& scenes = command.drives.scenes;
  if (!request.logs.empty()) {
    if (scenes.size() > 1) refuse("--scene: logs are replayed with one scene; sweep them one by one");
    if (!scenes.empty()) request.scene = scenes.front();
    return {};
  }
  if (scenes.empty()) refuse("no log; give LOG, or --scene SCENE to simulate a drive");
  if (command.output.out.empty()) command.temporary.emplace();
  const std::string folder =
      command.temporary ? command.temporary->file("drives") : command.output.out + "/drives";
  command.drives.overrides.swap(request.overrides);
  command.drives.maps = request.maps;
  std::vector<SimulatedDrive> drives = simulate_drives(context, command.drives, folder);
  for (const SimulatedDrive& drive : drives) request.logs.push_back(drive.log);
  return drives;
}

void show(const CommandContext& context, const SweepCommand& command, const SweepSet& set) {
  show_sweep_set(context, command.output, set);
  if (command.output.out.empty()) return;
  std::cerr << "sweep: " << command.output.out << "/sweep.json and what lies beside it\n";
}

int run_here(const CommandContext& context, SweepCommand& command) {
  const SweepOptions options = sweep_options(command.request);
  std::vector<LogSweep> sweeps;
  const auto bar = progress_bar(command.output, "bench");
  const auto count = static_cast<double>(command.request.logs.size());
  double done = 0;
  for (const std::string& path : command.request.logs) {
    const firmware::LogFile log(path);
    std::vector<SweepOptions> planned = sweeps_of(log, context.parts.vehicles, options);
    const double each = 1 / (count * static_cast<double>(planned.size()));
    for (SweepOptions& one : planned) {
      if (bar) one.progress = [&bar, done, each](double share) { bar(done + share * each); };
      sweeps.push_back({path, run_sweep(log, context.parts.vehicles, one)});
      done += each;
    }
    for (const std::string& problem : log.problems()) sweeps.back().sweep.warnings.push_back(problem);
    if (command.damage.empty()) command.damage = log.damage();
  }
  show(context, command, make_sweep_set(std::move(sweeps)));
  return 0;
}

SweepFolderPlan make_plan(const CommandContext& context, SweepCommand& command,
                          const std::vector<SimulatedDrive>& drives) {
  SweepFolderPlan plan;
  const SweepOptions options = sweep_options(command.request);
  plan.program = digest_of_file(own_program_path());
  for (std::size_t i = 0; i < command.request.logs.size(); ++i) {
    std::string& path = command.request.logs[i];
    const firmware::LogFile log(path);
    path = fs::absolute(path).lexically_normal().string();
    const std::string identity = drives.empty() ? digest_of_file(path) : drives[i].identity;
    for (const SweepOptions& one : sweeps_of(log, context.parts.vehicles, options))
      plan.logs.push_back({path, identity, !drives.empty(), plan_sweep(log, context.parts.vehicles, one)});
    plan.logs.back().plan.sweep.warnings = log.problems();
    if (command.damage.empty()) command.damage = log.damage();
  }
  plan.request = command.request;
  // Cells run in other folders: files are named from the root.
  firmware::KeptMapPaths::fields(plan.request.maps, [](const char*, std::string& path) {
    if (!path.empty()) path = fs::absolute(path).lexically_normal().string();
  });
  std::string& scene = plan.request.scene;
  if (scene.size() > 5 && scene.substr(scene.size() - 5) == ".toml") scene = fs::absolute(scene).string();
  write_plan(command.output.out, plan);
  return plan;
}

// A bar with the time that is left on a terminal, else a line a cell.
void tell_cell(const SweepFolderPlan& plan, const OutputOptions& output, std::size_t done, std::size_t all,
               std::size_t cell, double took_s, double left_s) {
  if (output.quiet) return;
  if (isatty(STDERR_FILENO) == 0) {
    std::fprintf(stderr, "cell %zu, %zu of %zu, %.1f s, %.0f s left: %s\n", cell, done, all, took_s, left_s,
                 plan.title(cell).c_str());
    return;
  }
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = done * kWidth / all;
  const auto left = static_cast<long>(std::lround(left_s));
  std::fprintf(stderr, "\rsweep [%s%s] %zu of %zu, %ld:%02ld left \033[K%s", std::string(filled, '#').c_str(),
               std::string(kWidth - filled, ' ').c_str(), done, all, left / 60, left % 60,
               done == all ? "\n" : "");
}

int write_script(const SweepFolderPlan& plan, const SweepCommand& command) {
  const std::string folder = fs::absolute(command.output.out).lexically_normal().string();
  const ArrayScript script{own_program_path(), folder, plan.cell_count()};
  const std::string path = fs::absolute(command.slurm).lexically_normal().string();
  write_file(path, script.text());
  remember_script(folder, path, script);
  std::cerr << "planned: " << plan.cell_count() << " cells; submit them with: sbatch " << path
            << "\nthen: sortie merge " << folder << "\n";
  return 0;
}

int run_in_folder(const CommandContext& context, SweepCommand& command,
                  const std::vector<SimulatedDrive>& drives) {
  const auto [shard, shards] = parse_shard(command.shard);
  const SweepFolderPlan plan = make_plan(context, command, drives);
  if (!command.slurm.empty()) return write_script(plan, command);
  SweepJobsOptions jobs;
  jobs.folder = command.output.out;
  jobs.jobs = std::max<std::size_t>(1, command.jobs);
  jobs.cells = shard_cells(plan.cell_count(), shard, shards);
  jobs.on_cell = [&](std::size_t done, std::size_t all, std::size_t cell, double took_s, double left_s) {
    tell_cell(plan, command.output, done, all, cell, took_s, left_s);
  };
  const SweepJobsEnd end = run_sweep_jobs(plan, jobs);
  if (end.taken != 0) std::cerr << end.taken << " cells were there already\n";
  if (end.stale != 0)
    std::cerr << end.stale << " cells were of another program, log or setting, and were run again\n";
  if (end.signal != 0) {
    std::cerr << context.parts.name << ": stopped; the same command goes on where it was\n";
    return 128 + end.signal;
  }
  for (const std::size_t cell : end.failed)
    std::cerr << "FAILED  cell " << cell << ": " << plan.title(cell) << "\n";
  if (!end.failed.empty()) return 1;
  if (shards > 1) {
    std::cerr << "shard " << command.shard << ": " << jobs.cells.size() << " of " << plan.cell_count()
              << " cells in " << command.output.out << "; `sortie merge` takes all shards together\n";
    return 0;
  }
  std::vector<std::size_t> missing;
  const SweepSet set = gather_sweep(plan, {command.output.out}, missing);
  if (!missing.empty()) {
    throw firmware::InputError(command.output.out + "/" + cell_file(missing.front()) +
                               ": went while the sweep ran; start it again, what is done is not done twice");
  }
  show(context, command, set);
  return 0;
}

int run_cells(const CommandContext& context, const SweepCommand& command) {
  for (const std::size_t cell : parse_cells(command.cells))
    run_sweep_cell(command.output.out, cell, context.parts.vehicles);
  return 0;
}

int run(const CommandContext& context, SweepCommand& command) {
  if ((command.in_folder() || !command.cells.empty()) && command.output.out.empty())
    refuse("--jobs, --shard, --slurm and --cell keep cells as files; add --out DIR");
  if (!command.cells.empty()) return run_cells(context, command);
  if (command.request.knobs.empty()) refuse("nothing to sweep; add --sweep key=v1,v2,v3 or --sweep knobs");
  const std::vector<SimulatedDrive> drives = take_drives(context, command);
  const int code = command.in_folder() ? run_in_folder(context, command, drives) : run_here(context, command);
  return firmware::code_with_damage(context.parts.name, command.damage, command.accept_damage, code);
}

}  // namespace

void add_bench_sweep(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<SweepCommand>();
  SweepRequest& request = options->request;
  bench.add_option("log,--log", request.logs, "LCM logs from `run --record` or `import`")->type_name("LOG");
  bench
      .add_option("--sweep", request.knobs,
                  "Key of the profile and its values: key=v1,v2,v3; or knobs: each knob of the scene's "
                  "estimators and map alone")
      ->take_all()
      ->delimiter('\n');
  bench
      .add_option("--scene", options->drives.scenes,
                  "Another scene than the log's own; needed for imported logs. Without a log: simulate it")
      ->expected(1, 1)  // each time: a log may follow
      ->take_all();
  bench.add_option("--seconds", options->drives.seconds, "Without a log: how long to simulate")
      ->in_range(0.01, 1e5)
      ->capture_default_str();
  bench.add_option("--seeds", options->drives.seeds, "Without a log: drives, each with another hil.seed")
      ->in_range(1, 1000)
      ->capture_default_str();
  add_map_options(bench, request.maps);
  bench.add_option("--set", request.overrides, "Override a key in all cells: key=value")->take_all();
  bench.add_flag("--instructions", request.instructions,
                 "Count the instructions of every cell, too, under callgrind: slow, and the same each time");
  bench.add_option("--repeat", request.repeat, "Replays of every cell")
      ->in_range(1, 1000)
      ->capture_default_str();
  bench
      .add_option("--task", request.tasks,
                  "Whose run time counts, if not that of the tasks the keys belong to")
      ->take_all();
  bench.add_option("--error", request.error, "Which error counts, as named in `replay --json`");
  bench
      .add_option("--jobs", options->jobs,
                  "So many processes, a cell each; cells are kept in --out, and a stopped sweep goes on")
      ->in_range(1, 1024);
  bench.add_option("--shard", options->shard, "Only every n-th cell, from the i-th on; see `merge`")
      ->type_name("i/n");
  bench.add_option("--slurm", options->slurm, "Run nothing, write an array script for sbatch")
      ->type_name("FILE");
  bench.add_option("--cell", options->cells, "Run these cells of the sweep that is planned in --out")
      ->type_name("LIST");
  add_alignment_option(bench, request.align);
  add_calibration_option(bench, request.calibrate_s);
  add_damage_option(bench, options->accept_damage);
  bench.add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  bench.add_flag("--quiet", options->output.quiet, "No progress");
  bench
      .add_option("--out", options->output.out,
                  "Folder for sweep.csv, sweep.json, sweep.md and sweep.svg, and for cells and drives")
      ->type_name("DIR");
  bench.callback([&bench, &context, options] {
    if (bench.has_chosen_subcommand()) return;
    context.chosen = [&context, options] { return run(context, *options); };
  });
}

}  // namespace sortie::toolchain
