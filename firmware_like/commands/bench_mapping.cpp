// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench mapping`: the local map beside PCL, and its error over run time.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/mapping_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/results.hpp"

namespace sortie::firmware {

namespace {

struct MappingCommandLine {
  MappingBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const MappingCommandLine& options) {
  const Json result = run_mapping_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_mapping_bench(std::cout, result, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-local-map.json", [&](std::ostream& out) { out << result.dump() << "\n"; });
    write_file(folder + "/bench-local-map.md",
               [&](std::ostream& out) { out << mapping_bench_page(result, context.command_line); });
    for (const MappingPicture& picture : mapping_pictures(result)) {
      write_file(folder + "/" + picture.file,
                 [&](std::ostream& out) { out << render(picture.plot) << "\n"; });
    }
    std::cerr << "report: " << folder << "/bench-local-map.{md,json} and pictures\n";
  }
  return 0;
}

}  // namespace

void add_bench_mapping(Command& bench, CommandContext& context) {
  auto options = std::make_shared<MappingCommandLine>();
  Command* command = bench.add_subcommand(
      "mapping", "The local map beside PCL: run time, memory, normals; error of segments over run time");
  command->footer(
      "Thread CPU time on recorded scans and in a simulated hall. docs/mapping.md tells what the map is.\n"
      "Examples:\n"
      "  sortie bench mapping --out out/mapping\n"
      "  sortie bench mapping --only sweep --json\n"
      "  sortie bench mapping --only peers --every 35 --count");
  command->add_option("--stride", options->bench.stride, "Every n-th point of the recorded scans")
      ->in_range(1, 1000000)
      ->capture_default_str();
  command->add_option("--every", options->bench.every, "Scans between two looks at PCL")
      ->in_range(1, 1000000)
      ->capture_default_str();
  command->add_flag("--count", options->bench.count, "Also count the instructions of each step: minutes");
  command->add_option("--only", options->bench.only, "One part alone")
      ->one_of({"peers", "insertion", "normals", "sweep"});
  command->add_option("--stream", options->bench.stream, "One stream of the sweep alone")
      ->one_of({"walk", "dense", "hall"});
  command->add_option("--file", options->bench.file, "Another recorded drive (.rls)")->type_name("FILE");
  command
      ->add_option("--program", options->bench.program,
                   "sortie-bench-mapping, where it is not found by itself")
      ->type_name("FILE");
  add_passes(*command, options->bench.passes);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command
      ->add_option("--out", options->output.out,
                   "Folder for bench-local-map.md, bench-local-map.json and pictures")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
