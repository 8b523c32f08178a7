// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench plant`: the tracked plant beside ODE.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/plant_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/results.hpp"

namespace sortie::firmware {

namespace {

struct PlantCommandLine {
  PlantBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const PlantCommandLine& options) {
  const Json result = run_plant_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_plant_bench(std::cout, result, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-plant.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-plant.md",
               [&](std::ostream& out) { out << plant_bench_page(result, context.command_line); });
    for (const PlantPicture& picture : plant_pictures(result)) {
      write_file(folder + "/" + picture.file,
                 [&](std::ostream& out) { out << render(picture.plot) << "\n"; });
    }
    std::cerr << "report: " << folder << "/bench-plant.{md,json} and pictures\n";
  }
  return 0;
}

}  // namespace

void add_bench_plant(Command& bench, CommandContext& context) {
  auto options = std::make_shared<PlantCommandLine>();
  Command* command = bench.add_subcommand(
      "plant", "The tracked plant beside ODE: run time, errors, turning, step size, penetration");
  command->footer(
      "Ours and ODE's slices alternate, so ratios hold on a busy machine, too. docs/plant.md tells what the "
      "model is.\n"
      "Examples:\n"
      "  sortie bench plant --out out/plant\n"
      "  sortie bench plant --only speed --scene pallet --rounds 11\n"
      "  sortie bench plant --only belt --json");
  command->add_option("--rounds", options->bench.rounds, "Rounds of what is timed; each holds slices of all")
      ->in_range(1, 10000)
      ->capture_default_str();
  command->add_option("--only", options->bench.only, "One part alone")
      ->one_of({"speed", "count", "metrics", "belt", "steps", "depth", "pictures"});
  command->add_option("--scene", options->bench.scene, "One scene alone")
      ->one_of({"straight", "rotate", "circular", "ramp", "stairs-down", "stand", "pallet", "back-and-forth",
                "stairs-up"});
  command
      ->add_option("--program", options->bench.program, "sortie-bench-plant, where it is not found by itself")
      ->type_name("FILE");
  add_passes(*command, options->bench.passes);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command
      ->add_option("--out", options->output.out, "Folder for bench-plant.md, bench-plant.json and pictures")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
