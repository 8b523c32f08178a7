// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <ostream>

#include "firmware_like/bench/rt_bench.hpp"
#include "firmware_like/text_format.hpp"

namespace sortie::firmware {

namespace {

using Json = nlohmann::ordered_json;

// One line of the table as texts.
struct Row {
  std::string what;
  std::string ours;
  std::string peer;
  std::string theirs;
  std::string ratio;
  std::string n;
  std::string goal;
  bool met{true};
};

std::string with_range(const Json& spread) {
  if (!spread.is_object() || !spread.contains("value") || !spread["value"].is_number()) return {};
  std::string text = format_short(spread["value"].get<double>());
  if (spread.contains("low") && spread["low"].is_number() && spread["high"].is_number())
    text += " (" + format_short(spread["low"].get<double>()) + " - " +
            format_short(spread["high"].get<double>()) + ")";
  return text;
}

Row row_of(const Json& figure) {
  Row row;
  row.what = figure.value("what", "");
  if (const std::string unit = figure.value("unit", ""); !unit.empty()) row.what += " [" + unit + "]";
  row.ours = with_range(figure.value("ours", Json::object()));
  row.peer = figure.value("peer", "");
  row.theirs = with_range(figure.value("theirs", Json::object()));
  row.ratio = with_range(figure.value("ratio", Json::object()));
  row.n = group_digits(figure.value("n", std::uint64_t{0}));
  row.goal = figure.value("goal", "");
  if (figure.contains("met") && figure["met"].is_boolean()) row.met = figure["met"].get<bool>();
  return row;
}

std::string verdict(const Row& row) {
  return row.goal.empty() ? "" : row.goal + (row.met ? ": met" : ": MISSED");
}

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
                    " after");
  }
  if (result.contains("doctor")) lines.push_back("doctor    " + result["doctor"].value("summary", ""));
  for (const char* when : {"before", "after"}) {
    if (const std::string line = noise_line(result.value("noise", Json::object()), when); !line.empty())
      lines.push_back("noise     " + line);
  }
  return lines;
}

std::vector<std::string> skips(const Json& result) {
  std::vector<std::string> lines;
  for (const Json& skip : result.value("skipped", Json::array()))
    lines.push_back(skip.value("what", "") + ": " + skip.value("why", ""));
  return lines;
}

std::vector<std::string> groups(const Json& result) {
  std::vector<std::string> names;
  for (const Json& figure : result["figures"]) {
    const std::string name = figure.value("group", "");
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

std::vector<std::string> notes(const Json& result, const std::string& group) {
  std::vector<std::string> lines;
  for (const Json& note : result.value("notes", Json::array())) {
    if (note.value("group", "") == group) lines.push_back(note.value("words", ""));
  }
  return lines;
}

}  // namespace

void print_rt_bench(std::ostream& out, const Json& result, bool colour) {
  for (const std::string& line : conditions(result)) out << line << "\n";
  for (const std::string& group : groups(result)) {
    out << "\n"
        << pad_right(group, 46) << pad_right("ours (range)", 25) << pad_right("theirs (range)", 25)
        << pad_right("ratio (range)", 25) << "n, goal\n";
    for (const Json& figure : result["figures"]) {
      if (figure.value("group", "") != group) continue;
      const Row row = row_of(figure);
      out << "  " << pad_right(row.what, 44) << pad_right(row.ours, 25) << pad_right(row.theirs, 25)
          << pad_right(row.ratio, 25) << row.n;
      if (!row.peer.empty()) out << "  " << row.peer;
      if (const std::string goal = verdict(row); !goal.empty())
        out << "  " << (colour && !row.met ? "\033[31m" + goal + "\033[0m" : goal);
      out << "\n";
    }
    for (const std::string& line : notes(result, group)) out << "  " << line << "\n";
  }
  out << "\n";
  for (const std::string& line : skips(result)) out << "skipped   " << line << "\n";
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
  for (const std::string& group : groups(result)) {
    text += "\n## " + group + "\n";
    if (group == "wake-up") text += "\n![lateness of wake-ups](bench-rt-wake.svg)\n";
    text += "\n| figure | ours | peer | theirs | ratio | n | goal |\n|---|---:|---|---:|---:|---:|---|\n";
    for (const Json& figure : result["figures"]) {
      if (figure.value("group", "") != group) continue;
      const Row row = row_of(figure);
      text += "| " + row.what + " | " + row.ours + " | " + row.peer + " | " + row.theirs + " | " + row.ratio +
              " | " + row.n + " | " + verdict(row) + " |\n";
    }
    for (const std::string& line : notes(result, group)) text += "\n" + line + "\n";
  }
  for (const std::string& line : skips(result)) text += "\nskipped: " + line + "\n";
  return text;
}

}  // namespace sortie::firmware
