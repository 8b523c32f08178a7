// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>

#include "firmware_like/bench/figure_passes.hpp"
#include "firmware_like/bench/figure_table.hpp"
#include "firmware_like/bench/plant_bench.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

std::vector<std::string> plant_conditions(const Json& result) {
  std::vector<std::string> lines;
  lines.push_back("machine   " + result.value("machine", "") + "; " + result.value("compiler", ""));
  const Json settings = result.value("settings", Json::object());
  lines.push_back("settings  " + std::to_string(settings.value("rounds", 0)) + " rounds, load average " +
                  result.value("load_before", "?") + " before, " + result.value("load_after", "?") +
                  " after" + passes_words(result));
  if (result.contains("doctor")) lines.push_back("doctor    " + result["doctor"].value("summary", ""));
  return lines;
}

// What a group is about, before its tables.
std::string heading(const std::string& group) {
  if (group == "speed") return "Run time of a step";
  if (group == "instructions") return "Instructions of a step";
  if (group == "metrics") return "Where drives end: contact surface motion";
  if (group == "belt") return "How belts turn";
  if (group == "step size") return "Error against step size against run time";
  if (group == "penetration") return "Penetration and residual";
  return group;
}

std::string scene_list(const Json& result) {
  std::string text = "\n| scene | drive | friction |\n|---|---|---:|\n";
  for (const Json& scene : result.value("scenes", Json::array())) {
    text += "| " + scene.value("name", "") + " | " + scene.value("about", "") + " | " +
            format_short(scene.value("friction", 0.0)) + " |\n";
  }
  return text;
}

}  // namespace

void print_plant_bench(std::ostream& out, const Json& result, bool colour) {
  for (const std::string& line : plant_conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string plant_bench_page(const Json& result, const std::string& command) {
  std::string text = "# The tracked plant beside ODE\n\n";
  text +=
      "Written by `" + command +
      "`. Ours and the peer's figures come from alternating slices of the same run: **the ratios travel, "
      "absolute times do not**. Figures are medians of the rounds, in brackets the range over the rounds; "
      "ratio is ours over theirs. The model: [plant](../plant.md).\n\n```\n";
  for (const std::string& line : plant_conditions(result)) text += line + "\n";
  text += "```\n" + scene_list(result);
  const std::vector<PlantPicture> pictures = plant_pictures(result);
  for (const std::string& group : figure_groups(result)) {
    text += "\n## " + heading(group) + "\n";
    if (group == "step size" && !pictures.empty() && pictures.front().file == "bench-plant-step.svg")
      text += "\n![error over run time](bench-plant-step.svg)\n";
    text += figures_page(result, group) + tables_page(result, group);
  }
  bool first = true;
  for (const PlantPicture& picture : pictures) {
    if (picture.file == "bench-plant-step.svg") continue;
    if (first) text += "\n## Side views\n";
    first = false;
    text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
  }
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace sortie::firmware
