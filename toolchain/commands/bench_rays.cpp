// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench rays`: the ray scheduler beside the published planners.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/result/results.hpp"
#include "toolchain/bench/ray_bench.hpp"
#include "toolchain/bench/ray_loop.hpp"
#include "toolchain/commands/bench_commands.hpp"
#include "toolchain/export/output_file.hpp"

namespace sortie::toolchain {

namespace {

struct RayCommandLine {
  RayBenchOptions bench;
  OutputOptions output;
  bool seeds_given{};
};

int run(const CommandContext& context, const RayCommandLine& options) {
  const bool loop = options.bench.only == "loop";
  const firmware::Json result =
      loop ? run_ray_loop(options.seeds_given ? options.bench.seeds : kLoopSeeds, options.bench.program)
           : run_ray_bench(options.bench);
  const std::string name = loop ? "/bench-rays-loop" : "/bench-rays";
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_ray_bench(std::cout, result, firmware::wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + name + ".json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + name + ".md", [&](std::ostream& out) {
      out << (loop ? ray_loop_page(result, context.command_line)
                   : ray_bench_page(result, context.command_line));
    });
    for (const RayPicture& picture : loop ? ray_loop_pictures(result) : ray_pictures(result)) {
      write_file(folder + "/" + picture.file,
                 [&](std::ostream& out) { out << render(picture.plot) << "\n"; });
    }
    std::cerr << "report: " << folder << name << ".{md,json} and pictures\n";
  }
  return 0;
}

}  // namespace

void add_bench_rays(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<RayCommandLine>();
  firmware::Command* command = bench.add_subcommand(
      "rays", "The ray scheduler beside the published planners: worth over run time, budgets, hard maps");
  command->footer(
      "All planners run in one process on the same tasks, so ratios hold on a busy machine, too. "
      "docs/rays.md "
      "tells what is planned and how.\n"
      "Examples:\n"
      "  sortie bench rays --out out/rays\n"
      "  sortie bench rays --only units\n"
      "  sortie bench rays --only curves --seeds 1 --json\n"
      "  sortie bench rays --only loop --out out/loop");
  command->add_option("--rounds", options->bench.rounds, "Rounds of what is timed")
      ->in_range(1, 10000)
      ->capture_default_str();
  firmware::Option* seeds = command->add_option(
      "--seeds", options->bench.seeds, "Streets of each kind; of the loop: pairs a scene, 12 unless given");
  seeds->in_range(1, 1000)->capture_default_str();
  command
      ->add_option("--only", options->bench.only,
                   "One part alone; loop: closed loops of policies, which nothing else runs")
      ->one_of({"curves", "units", "picture", "loop"});
  command
      ->add_option("--program", options->bench.program, "sortie-bench-rays, where it is not found by itself")
      ->type_name("FILE");
  add_passes(*command, options->bench.passes);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for bench-rays.md, bench-rays.json and pictures")
      ->type_name("DIR");
  command->callback([&context, options, seeds] {
    options->seeds_given = seeds->count() > 0;
    context.chosen = [&context, options] { return run(context, *options); };
  });
}

}  // namespace sortie::toolchain
