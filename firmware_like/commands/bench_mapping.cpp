// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench mapping`: the local map beside PCL, and error against run time.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/map_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"

namespace sortie::firmware {

namespace {

struct MapCommandLine {
  MapBenchOptions bench;
  OutputOptions output;
};

int run_mapping(const CommandContext& context, const MapCommandLine& options) {
  const nlohmann::ordered_json result = run_map_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_map_bench(std::cout, result, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-mapping.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-mapping.md",
               [&](std::ostream& out) { out << map_bench_page(result, context.command_line); });
    for (const MapPicture& picture : map_pictures(result)) {
      write_file(folder + "/" + picture.file,
                 [&](std::ostream& out) { out << render(picture.plot) << "\n"; });
    }
    std::cerr << "report: " << folder << "/bench-mapping.{md,json} and pictures\n";
  }
  return 0;
}

}  // namespace

void add_bench_mapping(CLI::App& bench, CommandContext& context) {
  auto options = std::make_shared<MapCommandLine>();
  CLI::App* command = bench.add_subcommand(
      "mapping", "The local map beside PCL's batch functions; voxel, points and budgets against error");
  command->footer(
      "The map and PCL run in one process on the same voxels, so ratios hold on a busy machine, too. "
      "docs/mapping.md tells what the parts are.\n"
      "Examples:\n"
      "  sortie bench mapping --out out/mapping\n"
      "  sortie bench mapping --only knobs --seed 7\n"
      "  sortie bench mapping --only peers --log my_drive.rls --json");
  command->add_option("--log", options->bench.log, "Recorded scans (.rls) in place of those of the tests")
      ->type_name("FILE")
      ->check(CLI::ExistingFile);
  command->add_option("--every", options->bench.every, "Scans between two looks at PCL")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--seed", options->bench.seed, "Seed of the simulated hall")->capture_default_str();
  command->add_flag("--count", options->bench.count,
                    "Also the instructions of each step, by valgrind; takes minutes");
  command->add_option("--only", options->bench.only, "One part alone")
      ->check(CLI::IsMember({"peers", "knobs"}));
  command
      ->add_option("--program", options->bench.program,
                   "sortie-bench-mapping, where it is not found by itself")
      ->type_name("FILE");
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command
      ->add_option("--out", options->output.out,
                   "Folder for bench-mapping.md, bench-mapping.json and pictures")
      ->type_name("DIR");
  command->callback([&context, options] {
    context.chosen = [&context, options] { return run_mapping(context, *options); };
  });
}

}  // namespace sortie::firmware
