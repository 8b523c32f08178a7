// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench rt`: the real-time ground beside cyclictest and boost.
#include <unistd.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/rt_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/results.hpp"

namespace sortie::firmware {

namespace {

struct RtCommand {
  RtBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const RtCommand& options) {
  const Json result = run_rt_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_rt_bench(std::cout, result, wants_colour(STDOUT_FILENO));
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-rt.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-rt.md",
               [&](std::ostream& out) { out << rt_bench_page(result, context.command_line); });
    write_file(folder + "/bench-rt-wake.svg",
               [&](std::ostream& out) { out << render(plot_wake_ups(result)) << "\n"; });
    std::cerr << "report: " << folder << "/bench-rt.{md,json}, bench-rt-wake.svg\n";
  }
  return 0;
}

}  // namespace

void add_bench_rt(Command& bench, CommandContext& context) {
  auto options = std::make_shared<RtCommand>();
  Command* command = bench.add_subcommand(
      "rt", "The real-time ground beside cyclictest and boost: wake-ups, queues, executive, system calls");
  command->footer(
      "Ours and the peers' slices alternate, so ratios hold on a busy machine, too. docs/timing.md tells how "
      "to read "
      "it.\n"
      "Examples:\n"
      "  sortie bench rt\n"
      "  sortie bench rt --load 4 --core 1 --out out/loaded\n"
      "  sortie bench rt --only wake --rounds 5760 --slice 5     # 24 hours");
  command
      ->add_option("--rounds", options->bench.rounds,
                   "Rounds of every part; each holds a slice of every peer")
      ->in_range(1, 1000000)
      ->capture_default_str();
  command->add_option("--slice", options->bench.slice_s, "Seconds of one slice of wake-ups")
      ->in_range(0.05, 3600.0)
      ->capture_default_str();
  command->add_option("--core", options->bench.core, "The core to measure; the last one unless said")
      ->not_negative()
      ->type_name("N");
  command->add_option("--load", options->bench.load, "Busy ordinary processes beside the wake-ups")
      ->in_range(0, 1024)
      ->capture_default_str();
  command->add_option("--only", options->bench.only, "One part alone")
      ->one_of({"wake", "queue", "count", "mailbox", "executive", "calls", "cause", "load"});
  command->add_option("--program", options->bench.program, "sortie-bench-rt, where it is not found by itself")
      ->type_name("FILE");
  add_passes(*command, options->bench.passes);
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for bench-rt.md, bench-rt.json and the plot")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
