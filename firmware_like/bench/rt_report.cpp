// SPDX-License-Identifier: BSD-3-Clause
#include <ostream>

#include "firmware_like/bench/figure_passes.hpp"
#include "firmware_like/bench/figure_table.hpp"
#include "firmware_like/bench/rt_bench.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

std::string noise_line(const Json& noise, const char* when) {
  if (!noise.contains(when)) return {};
  const Json& one = noise[when];
  const auto value = [&one](const char* key) { return format_short(one.value(key, 0.0)); };
  return std::string(when) + ": " + value("gaps_per_s") + " gaps above 2 us a second, p50 " +
         value("p50_us") + ", p99 " + value("p99_us") + ", max " + value("max_us") + " us; " +
         value("lost_percent") + " % of the time";
}

std::vector<std::string> conditions(const Json& result) {
  std::vector<std::string> lines;
  lines.push_back("machine   " + result.value("machine", "") + "; " + result.value("compiler", ""));
  if (result.contains("settings")) {
    const Json& s = result["settings"];
    lines.push_back("settings  " + std::to_string(s.value("rounds", 0)) + " rounds, slices of " +
                    format_short(s.value("slice_s", 0.0)) + " s, core " + std::to_string(s.value("core", 0)) +
                    ", " + std::to_string(s.value("load", 0)) + " busy processes beside, " +
                    (s.value("realtime", false) ? "SCHED_FIFO" : "ordinary scheduling") + ", load average " +
                    result.value("load_before", "?") + " before, " + result.value("load_after", "?") +
                    " after" + passes_words(result));
  }
  if (result.contains("doctor")) lines.push_back("doctor    " + result["doctor"].value("summary", ""));
  for (const char* when : {"before", "after"}) {
    if (const std::string line = noise_line(result.value("noise", Json::object()), when); !line.empty())
      lines.push_back("noise     " + line);
  }
  return lines;
}

}  // namespace

void print_rt_bench(std::ostream& out, const Json& result, bool colour) {
  for (const std::string& line : conditions(result)) out << line << "\n";
  for (const std::string& group : figure_groups(result)) print_figures(out, result, group, colour);
  out << "\n";
  for (const std::string& line : figure_skips(result)) out << "skipped   " << line << "\n";
}

std::string rt_bench_page(const Json& result, const std::string& command) {
  std::string text = "# The real-time ground beside its peers\n\n";
  text += "Written by `" + command +
          "`. Every figure and its peer's come from alternating slices of the same run: **the ratios travel, "
          "absolute times "
          "do not**. Figures are medians of the rounds (of all samples for wake-ups and mailboxes), in "
          "brackets the range "
          "over the rounds. "
          "How to read them: [timing](../timing.md).\n\n```\n";
  for (const std::string& line : conditions(result)) text += line + "\n";
  text += "```\n";
  for (const std::string& group : figure_groups(result)) {
    text += "\n## " + group + "\n";
    if (group == "wake-up") text += "\n![lateness of wake-ups](bench-rt-wake.svg)\n";
    text += figures_page(result, group);
  }
  for (const std::string& line : figure_skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace sortie::firmware
