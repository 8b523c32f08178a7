// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "firmware_like/bench/scene_advice.hpp"
#include "firmware_like/json.hpp"

namespace sortie::firmware {

namespace {

const char* verdict_word(PartVerdict verdict) {
  switch (verdict) {
    case PartVerdict::no_input:
      return "no input";
    case PartVerdict::never_mattered:
      return "never mattered";
    case PartVerdict::did_not_help:
      return "did not help";
    case PartVerdict::mattered:
      return "mattered";
    case PartVerdict::would_matter:
      return "would have mattered";
    case PartVerdict::would_not:
      return "would not have";
    case PartVerdict::not_judged:
      break;
  }
  return "not judged";
}

}  // namespace

Json to_json(const Advice& advice) {
  Json object{{"scene", advice.scene},
              {"log", advice.log},
              {"ticks", advice.ticks},
              {"judged_by", advice.judged_by},
              {"most_inclined_deg", advice.most_inclined_deg}};
  object["parts"] = Json::array();
  for (const AdviceLine& line : advice.lines) {
    Json entry{{"part", line.part}, {"verdict", verdict_word(line.verdict)}, {"figure", line.figure}};
    entry["pose_moved_m"] = line.pose_moved_m;
    if (line.error) entry["error"] = *line.error;
    if (line.changed) entry["error_changed"] = *line.changed;
    entry["bytes"] = line.bytes;
    entry["us_per_tick"] = line.us_per_tick;
    object["parts"].push_back(entry);
  }
  return object;
}

std::string advice_text(const Advice& advice) {
  std::string text = advice.scene + ", " + std::to_string(advice.ticks) + " ticks, " +
                     (advice.judged_by.empty() ? "no truth in the log" : "judged by " + advice.judged_by) +
                     "\n";
  for (const AdviceLine& line : advice.lines) {
    char row[64];
    std::snprintf(row, sizeof(row), "%-16s %-20s ", line.part.c_str(), verdict_word(line.verdict));
    text += row + line.figure;
    if (line.bytes != 0 || line.us_per_tick != 0) {
      std::snprintf(row, sizeof(row), " (%.2f MB, %.2f us/tick)", 1e-6 * static_cast<double>(line.bytes),
                    line.us_per_tick);
      text += row;
    }
    text += "\n";
  }
  return text;
}

}  // namespace sortie::firmware
