// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench all`: every part's benchmark into one folder.
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/scene/json.hpp"
#include "toolchain/bench/bench_all.hpp"
#include "toolchain/commands/commands.hpp"
#include "toolchain/export/output_file.hpp"

namespace sortie::toolchain {

namespace {

struct BenchAllCommand {
  BenchAllOptions bench;
  OutputOptions output;
};

int run(const CommandContext& context, BenchAllCommand& options) {
  options.bench.folder = options.output.out;
  if (!options.output.quiet) {
    options.bench.on_part = [](std::size_t part, std::size_t parts, const std::string& name, double since_s) {
      std::fprintf(stderr, "part %zu of %zu, after %.0f s: %s\n", part + 1, parts, since_s, name.c_str());
    };
  }
  const firmware::Json index = run_bench_all(options.bench);
  const std::string page = bench_all_page(index, context.command_line);
  write_file(options.output.out + "/index.json", index.dump(2) + "\n");
  write_file(options.output.out + "/index.md", page);
  std::cout << (options.output.json ? index.dump(2) + "\n" : page);
  std::cerr << "report: " << options.output.out << "/index.{md,json}\n";
  int code = 0;
  for (const auto& part : index["parts"])
    if (!part.value("written", false)) code = 4;
  return code;
}

}  // namespace

void add_bench_all(firmware::Command& bench, CommandContext& context) {
  auto options = std::make_shared<BenchAllCommand>();
  std::vector<std::string> names;
  for (const BenchPart& part : bench_parts()) names.push_back(part.name);
  firmware::Command* command =
      bench.add_subcommand("all", "Every part's benchmark, into one folder with one page");
  command->footer(
      "Exit code 4: a part could not run.\n"
      "Example:\n"
      "  sortie bench all --out out/today");
  command
      ->add_option("--out", options->output.out, "Folder for index.md, index.json and a folder of each part")
      ->required()
      ->type_name("DIR");
  command->add_option("--only", options->bench.only, "These parts alone")->one_of(names)->take_all();
  command
      ->add_option("--passes", options->bench.passes,
                   "Processes a part that has peers; their ranges hold all of them")
      ->in_range(1, 100)
      ->capture_default_str();
  command->add_flag("--json", options->output.json, "Print index.json instead of the page");
  command->add_flag("--quiet", options->output.quiet, "No line a part");
  command->callback(context.choose([&context, options] { return run(context, *options); }));
}

}  // namespace sortie::toolchain
