// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/peer_front.hpp"

#include <algorithm>
#include <ostream>

#include "toolchain/bench/figure_passes.hpp"
#include "toolchain/bench/figure_table.hpp"

namespace sortie::toolchain {

const std::vector<PeerFront>& peer_fronts() {
  static const std::vector<PeerFront> fronts{
      rt_front(),        plant_front(),     mapping_front(),  registration_front(), recognition_front(),
      elevation_front(), posture_front(),   courses_front(),  flipper_front(),      ground_path_front(),
      uav_front(),       stability_front(), campaign_front(), ray_front()};
  return fronts;
}

std::string settings_line(const firmware::Json& result, const std::string& settings) {
  return "settings  " + settings + ", load average " + result.value("load_before", "?") + " before, " +
         result.value("load_after", "?") + " after" + passes_words(result);
}

std::vector<std::string> bench_conditions(const PeerFront& front, const firmware::Json& result) {
  std::vector<std::string> lines{"machine   " + result.value("machine", "") + "; " +
                                 result.value("compiler", "")};
  if (front.conditions != nullptr)
    for (std::string& line : front.conditions(result)) lines.push_back(std::move(line));
  if (result.contains("doctor"))
    lines.insert(lines.begin() + std::min<std::ptrdiff_t>(2, std::ssize(lines)),
                 "doctor    " + result["doctor"].value("summary", ""));
  return lines;
}

void print_bench(std::ostream& out, const PeerFront& front, const firmware::Json& result, bool colour) {
  if (front.print != nullptr) return front.print(out, result, colour);
  for (const std::string& line : bench_conditions(front, result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) {
    print_figures(out, result, group, colour);
    print_tables(out, result, group);
  }
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string bench_page(const PeerFront& front, const firmware::Json& result, const std::string& command) {
  if (front.page != nullptr) return front.page(result, command);
  std::string text = "# " + front.title + "\n\nWritten by `" + command + "`. " + front.intro + "\n\n```\n";
  for (const std::string& line : bench_conditions(front, result)) text += line + "\n";
  text += "```\n";
  if (front.overview != nullptr) text += front.overview(result);
  const std::vector<BenchPicture> pictures =
      front.pictures != nullptr ? front.pictures(result) : std::vector<BenchPicture>{};
  std::vector<std::string> groups = figure_groups(result);
  for (const BenchPicture& picture : pictures) {
    if (std::find(groups.begin(), groups.end(), picture.group) == groups.end())
      groups.push_back(picture.group);
  }
  for (const std::string& group : groups) {
    const auto heading = front.headings.find(group);
    text += "\n## " + (heading != front.headings.end() ? heading->second : group) + "\n";
    for (const BenchPicture& picture : pictures) {
      if (picture.group == group) text += "\n![" + picture.plot.title + "](" + picture.file + ")\n";
    }
    text += figures_page(result, group) + tables_page(result, group);
  }
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

bool all_met(const firmware::Json& result) {
  const firmware::Json figures = result.value("figures", firmware::Json::array());
  return !figures.empty() && std::all_of(figures.begin(), figures.end(),
                                         [](const firmware::Json& row) { return row.value("met", false); });
}

}  // namespace sortie::toolchain
