// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench uav`: the multirotor beside its peers.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/uav_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/results.hpp"

namespace sortie::firmware {

namespace {

struct UavCommandLine {
  UavBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const UavCommandLine& options) {
  const Json result = run_uav_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_uav_bench(std::cout, result, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-uav.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-uav.md",
               [&](std::ostream& out) { out << uav_bench_page(result, context.command_line); });
    for (const UavPicture& picture : uav_pictures(result)) {
      write_file(folder + "/" + picture.file,
                 [&](std::ostream& out) { out << render(picture.plot) << "\n"; });
    }
    std::cerr << "report: " << folder << "/bench-uav.{md,json} and pictures\n";
  }
  return 0;
}

}  // namespace

void add_bench_uav(Command& bench, CommandContext& context) {
  auto options = std::make_shared<UavCommandLine>();
  Command* command = bench.add_subcommand(
      "uav", "The multirotor beside its peers: flights, stress, error against run time, ways");
  command->footer(
      "Flights are simulated and repeat exactly; only run times depend on the machine. docs/uav.md tells "
      "what "
      "flies.\n"
      "Examples:\n"
      "  sortie bench uav --out out/uav\n"
      "  sortie bench uav --only stress --fleet 400\n"
      "  sortie bench uav --only rates --json");
  command->add_option("--seeds", options->bench.seeds, "Seeds of noise, a flight each")
      ->in_range(1, 1000)
      ->capture_default_str();
  command->add_option("--fleet", options->bench.fleet, "Vehicles that are drawn")
      ->in_range(1, 100000)
      ->capture_default_str();
  command->add_option("--only", options->bench.only, "One part alone")
      ->one_of({"peers", "stress", "estimated", "orders", "rates", "plant", "pictures", "paths", "count"});
  command
      ->add_option("--program", options->bench.program, "sortie-bench-uav, where it is not found by itself")
      ->type_name("FILE");
  add_passes(*command, options->bench.passes);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for bench-uav.md, bench-uav.json and pictures")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
