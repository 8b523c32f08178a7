// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>

#include "toolchain/bench/figure_table.hpp"
#include "toolchain/bench/peer_front.hpp"

namespace sortie::toolchain {

namespace {

constexpr int kLoopSeeds = 12;  // of each scene

std::vector<std::string> ray_conditions(const firmware::Json& result) {
  const firmware::Json settings = result.value("settings", firmware::Json::object());
  return {"machine   " + result.value("machine", "") + "; " + result.value("compiler", ""),
          settings_line(result, std::to_string(settings.value("rounds", 0)) + " rounds, " +
                                    std::to_string(settings.value("seeds", 0)) + " streets of each kind")};
}

void print_rays(std::ostream& out, const firmware::Json& result, bool colour) {
  for (const std::string& line : ray_conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  out << "\n";
}

std::string ray_page(const firmware::Json& result, const std::string& command) {
  std::string text = "# The ray scheduler beside the published planners\n\n";
  text +=
      "Written by `" + command +
      "`. All planners ran in one process on the same tasks, timed by their thread's processor time: **the "
      "ratios travel, absolute times do not**. Worth is the exact expected fall of entropy in double, over "
      "that of the corrected literal Algorithm 4. What is planned and how: [rays](../rays.md).\n\n```\n";
  for (const std::string& line : ray_conditions(result)) text += line + "\n";
  text += "```\n";
  for (const BenchPicture& picture : ray_pictures(result))
    text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
  for (const std::string& group : figure_groups(result))
    text += "\n## " + group + "\n" + figures_page(result, group) + tables_page(result, group);
  return text;
}

// Closed loops are a program of their own.
void choose_loop(PeerFront& front) {
  PeerOption seeds = front.options[1];
  if (std::get<std::string>(front.options[2].value) != "loop") return;
  if (!seeds.given) seeds.value = kLoopSeeds;
  front.name = "rays-loop";
  front.file = "bench-rays-loop";
  front.options = {seeds};
  front.has_passes = false;
  front.page = ray_loop_page;
  front.pictures = ray_loop_pictures;
}

}  // namespace

PeerFront ray_front() {
  PeerFront front;
  front.name = "rays";
  front.file = "bench-rays";
  front.about = "The ray scheduler beside the published planners: worth over run time, budgets, hard maps";
  front.footer =
      "All planners run in one process on the same tasks, so ratios hold on a busy machine, too. "
      "docs/rays.md "
      "tells what is planned and how.\n"
      "Examples:\n"
      "  sortie bench rays --out out/rays\n"
      "  sortie bench rays --only units\n"
      "  sortie bench rays --only curves --seeds 1 --json\n"
      "  sortie bench rays --only loop --out out/loop";
  front.options = {
      {"--rounds", 3, "Rounds of what is timed", 1, 10000},
      {"--seeds", 2, "Streets of each kind; of the loop: pairs a scene, 12 unless given", 1, 1000},
      choice("--only", "One part alone; loop: closed loops of policies, which nothing else runs",
             {"curves", "units", "picture", "loop"})};
  front.adapt = choose_loop;
  front.print = print_rays;
  front.page = ray_page;
  front.pictures = ray_pictures;
  return front;
}

}  // namespace sortie::toolchain
