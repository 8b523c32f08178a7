// SPDX-License-Identifier: BSD-3-Clause
// `sortie merge`: the cells of a sweep that ran in shards or on a cluster, put together.
#include <iostream>
#include <memory>

#include "firmware_like/scene/input_error.hpp"
#include "toolchain/bench/child_process.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/sweep/sweep_set.hpp"
#include "toolchain/sweep/sweep_slurm.hpp"

namespace sortie::toolchain {

namespace {

struct MergeCommand {
  std::vector<std::string> folders;
  bool resubmit{};
  OutputOptions output;
};

// All folders must be of one sweep: the same cells with the same keys.
void refuse_others(const SweepFolderPlan& plan, const MergeCommand& command) {
  for (const std::string& folder : command.folders) {
    const SweepFolderPlan other = read_plan(folder);
    bool same = other.cell_count() == plan.cell_count();
    for (std::size_t i = 0; same && i < plan.cell_count(); ++i) same = other.key(i) == plan.key(i);
    if (same) continue;
    throw firmware::InputError(folder + ": is of another sweep than " + command.folders.front() +
                                   " (another program, log, knob or setting); merge folders of one sweep",
                               2);
  }
}

int resubmit(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + word;
  if (words.front() != "sbatch") {
    std::cout << line << "\n";
    return 1;
  }
  if (find_in_path("sbatch").empty()) {
    std::cout << line << "\n";
    std::cerr << "sbatch is not here: run this line where it is, or apt-get install slurm-client\n";
    return 1;
  }
  std::cerr << line << "\n";
  const ChildEnd end =
      run_child({words, {}, false, 1}, [](std::string_view text) { std::cout << text << "\n"; });
  if (end.exit_code != 0)
    throw firmware::InputError(
        "sbatch ended with " + std::to_string(end.exit_code) + "; see what it said above", 4);
  return 1;
}

int run(const CommandContext& context, const MergeCommand& command) {
  const SweepFolderPlan plan = read_plan(command.folders.front());
  refuse_others(plan, command);
  std::vector<std::size_t> missing;
  const SweepSet set = gather_sweep(plan, command.folders, missing);
  if (!missing.empty()) {
    for (const std::size_t cell : missing)
      std::cerr << "missing cell " << cell << ": " << plan.title(cell) << "\n";
    std::cerr << context.parts.name << ": " << missing.size() << " of " << plan.cell_count()
              << " cells are missing: " << cell_list(missing)
              << (command.resubmit ? "\n" : "; --resubmit runs them again\n");
    if (!command.resubmit) return 1;
    return resubmit(resubmit_command(own_program_path(), command.folders.front(), missing));
  }
  show_sweep_set(context, command.output, set);
  return 0;
}

}  // namespace

void add_merge(firmware::Command& app, CommandContext& context) {
  auto options = std::make_shared<MergeCommand>();
  firmware::Command* command =
      app.add_subcommand("merge", "Put the cells of a sweep together that ran in several places");
  command->footer(
      "Exit code 1 while cells are missing; each is named.\n"
      "Examples:\n"
      "  sortie merge out/shard1 out/shard2 --out out/sweep\n"
      "  sortie merge /shared/sweep --resubmit");
  command->add_option("folders", options->folders, "Folders of `bench --shard` or `bench --slurm`")
      ->required()
      ->type_name("FOLDER");
  command->add_flag("--resubmit", options->resubmit,
                    "Submit the array tasks of missing cells again; without a script, print what runs them");
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command
      ->add_option("--out", options->output.out, "Folder for sweep.csv, sweep.json, sweep.md and sweep.svg")
      ->type_name("DIR");
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
