// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/ray_bench.hpp"

#include <ostream>

#include "toolchain/bench/figure_passes.hpp"
#include "toolchain/bench/figure_table.hpp"
#include "toolchain/bench/peer_program.hpp"

namespace sortie::toolchain {

namespace {

std::vector<std::string> ray_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {"machine   " + result.value("machine", "") + "; " + result.value("compiler", ""),
          "settings  " + std::to_string(settings.value("rounds", 0)) + " rounds, " +
              std::to_string(settings.value("seeds", 0)) + " streets of each kind, load average " +
              result.value("load_before", "?") + " before, " + result.value("load_after", "?") + " after" +
              passes_words(result)};
}

}  // namespace

firmware::Json run_ray_bench(const RayBenchOptions& options) {
  PeerProgram program{"sortie-bench-rays", options.program, {}, -1, options.passes};
  program.arguments = {"--rounds", std::to_string(options.rounds), "--seeds", std::to_string(options.seeds)};
  if (!options.only.empty()) program.arguments.insert(program.arguments.end(), {"--only", options.only});
  return run_peer_program(program);
}

void print_ray_bench(std::ostream& out, const firmware::Json& result, bool colour) {
  for (const std::string& line : ray_conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  out << "\n";
}

std::string ray_bench_page(const firmware::Json& result, const std::string& command) {
  std::string text = "# The ray scheduler beside the published planners\n\n";
  text +=
      "Written by `" + command +
      "`. All planners ran in one process on the same tasks, timed by their thread's processor time: **the "
      "ratios travel, absolute times do not**. Worth is the exact expected fall of entropy in double, over "
      "that of the corrected literal Algorithm 4. What is planned and how: [rays](../rays.md).\n\n```\n";
  for (const std::string& line : ray_conditions(result)) text += line + "\n";
  text += "```\n";
  for (const RayPicture& picture : ray_pictures(result))
    text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
  for (const std::string& group : figure_groups(result))
    text += "\n## " + group + "\n" + figures_page(result, group) + tables_page(result, group);
  return text;
}

}  // namespace sortie::toolchain
