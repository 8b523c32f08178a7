// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench stability`: stiff and extreme cases, each beside the naive method.
#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/stability_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"

namespace sortie::firmware {

namespace {

struct StabilityCommandLine {
  StabilityBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const StabilityCommandLine& options) {
  const Json result = run_stability_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_stability_bench(std::cout, result);
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-stability.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-stability.md",
               [&](std::ostream& out) { out << stability_bench_page(result, context.command_line); });
    std::cerr << "report: " << folder << "/bench-stability.{md,json}\n";
  }
  return is_stable(result) ? 0 : 1;
}

}  // namespace

void add_bench_stability(Command& bench, CommandContext& context) {
  auto options = std::make_shared<StabilityCommandLine>();
  Command* command =
      bench.add_subcommand("stability", "Stiff and extreme cases: ours within a bound, the naive method not");
  command->footer(
      "Exit code 0: every bound lies between ours and the naive method, 1: one does not. docs/stability.md\n"
      "tells what each case is.\n"
      "Examples:\n"
      "  sortie bench stability\n"
      "  sortie bench stability --only planner --json\n"
      "  sortie bench stability --out out/stability");
  command->add_option("--only", options->bench.only, "Cases of one part alone")
      ->one_of({"rt", "drivers", "estimators", "mapping", "planner", "hil"});
  command
      ->add_option("--program", options->bench.program,
                   "sortie-bench-stability, where it is not found by itself")
      ->type_name("FILE");
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for bench-stability.md and bench-stability.json")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
