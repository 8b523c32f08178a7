// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench campaign`: hostile random sequences for every module.
#include <filesystem>
#include <iostream>
#include <memory>

#include "firmware_like/bench/campaign_bench.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"

namespace sortie::firmware {

namespace {

struct CampaignCommandLine {
  CampaignBenchOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, const CampaignCommandLine& options) {
  const Json result = run_campaign_bench(options.bench);
  if (options.output.json) {
    std::cout << result.dump(2) << "\n";
  } else {
    print_campaign_bench(std::cout, result);
  }
  if (const std::string& folder = options.output.out; !folder.empty()) {
    std::filesystem::create_directories(folder);
    write_file(folder + "/bench-campaign.json", [&](std::ostream& out) { out << result.dump(2) << "\n"; });
    write_file(folder + "/bench-campaign.md",
               [&](std::ostream& out) { out << campaign_bench_page(result, context.command_line); });
    std::cerr << "report: " << folder << "/bench-campaign.{md,json}\n";
  }
  return is_faultless(result) ? 0 : 1;
}

}  // namespace

void add_bench_campaign(Command& bench, CommandContext& context) {
  auto options = std::make_shared<CampaignCommandLine>();
  Command* command = bench.add_subcommand("campaign", "Hostile random sequences for every module");
  command->footer(
      "Exit code 0: finite, bounded, counted, no heap, the same digest twice, in every module; 1: a fault, "
      "which\n"
      "is printed as a small sequence to run again. docs/stability.md tells what is drawn and checked.\n"
      "Examples:\n"
      "  sortie bench campaign\n"
      "  sortie bench campaign --only attitude --count 100000 --seed 7\n"
      "  sortie bench campaign --replay fault.txt");
  command->add_option("--only", options->bench.only, "One module alone")->type_name("MODULE");
  command
      ->add_option("--count", options->bench.count,
                   "Sequences of a cheap module; dear ones have a share of it")
      ->capture_default_str()
      ->in_range(std::uint64_t{1}, std::uint64_t{1'000'000'000});
  command->add_option("--seed", options->bench.seed, "Of all sequences; a fresh one unless given")
      ->in_range(std::uint64_t{0}, std::uint64_t{9'000'000'000'000'000});
  command->add_option("--replay", options->bench.replay, "Run the sequence in this file instead")
      ->type_name("FILE");
  command
      ->add_option("--program", options->bench.program,
                   "sortie-bench-campaign, where it is not found by itself")
      ->type_name("FILE");
  command->add_flag("--json", options->output.json, "Print one JSON object instead of the table");
  command->add_option("--out", options->output.out, "Folder for bench-campaign.md and bench-campaign.json")
      ->type_name("DIR");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
