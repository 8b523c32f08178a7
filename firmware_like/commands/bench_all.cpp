// SPDX-License-Identifier: BSD-3-Clause
// `sortie bench all`: every part's benchmark into one folder, and two such folders beside each other.
#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "firmware_like/bench/bench_all.hpp"
#include "firmware_like/commands/bench_commands.hpp"
#include "firmware_like/exporters/output_file.hpp"
#include "firmware_like/json.hpp"

namespace sortie::firmware {

namespace {

struct BenchAllCommand {
  BenchAllOptions bench;
  OutputOptions output;
  std::string compare;
  bool no_run{};
};

int show_comparison(const BenchAllCommand& options) {
  const BenchComparison result = compare_bench(options.compare, options.output.out);
  for (const std::string& line : result.missing) std::cout << "missing   " << line << "\n";
  for (const std::string& line : result.changed) std::cout << "CHANGED   " << line << "\n";
  for (const std::string& line : result.outside) std::cout << "OUTSIDE   " << line << "\n";
  std::cout << "compared  " << result.exact << " errors, " << result.changed.size() << " changed; "
            << result.ratios << " ratios, " << result.outside.size() << " outside; " << result.unjudged
            << " figures cannot be judged (times without a peer, or in one run only)\n";
  return result.changed.empty() && result.outside.empty() && result.missing.empty() ? 0 : 1;
}

int run(const CommandContext& context, BenchAllCommand& options) {
  if (options.no_run) return options.compare.empty() ? 0 : show_comparison(options);
  options.bench.folder = options.output.out;
  if (!options.output.quiet) {
    options.bench.on_part = [](std::size_t part, std::size_t parts, const std::string& name, double since_s) {
      std::fprintf(stderr, "part %zu of %zu, after %.0f s: %s\n", part + 1, parts, since_s, name.c_str());
    };
  }
  const Json index = run_bench_all(options.bench);
  const std::string page = bench_all_page(index, context.command_line);
  write_file(options.output.out + "/index.json", [&](std::ostream& out) { out << index.dump(2) << "\n"; });
  write_file(options.output.out + "/index.md", [&](std::ostream& out) { out << page; });
  std::cout << (options.output.json ? index.dump(2) + "\n" : page);
  std::cerr << "report: " << options.output.out << "/index.{md,json}\n";
  int code = 0;
  for (const auto& part : index["parts"])
    if (!part.value("written", false)) code = 4;
  return options.compare.empty() ? code : std::max(code, show_comparison(options));
}

}  // namespace

void add_bench_all(Command& bench, CommandContext& context) {
  auto options = std::make_shared<BenchAllCommand>();
  std::vector<std::string> names;
  for (const BenchPart& part : bench_parts()) names.push_back(part.name);
  Command* command = bench.add_subcommand("all", "Every part's benchmark, into one folder with one page");
  command->footer(
      "Exit code 1: --compare found an error that changed, or a ratio outside; 4: a part could not run.\n"
      "Examples:\n"
      "  sortie bench all --out out/today\n"
      "  sortie bench all --out out/today --compare out/last-release\n"
      "  sortie bench all --out out/today --compare out/last-release --no-run");
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
  command->add_option("--compare", options->compare, "An earlier --out: what changed since")
      ->type_name("FOLDER");
  command->add_flag("--no-run", options->no_run, "Only compare what is in --out already");
  command->add_flag("--json", options->output.json, "Print index.json instead of the page");
  command->add_flag("--quiet", options->output.quiet, "No line a part");
  command->callback(
      [&context, options] { context.chosen = [&context, options] { return run(context, *options); }; });
}

}  // namespace sortie::firmware
