// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "firmware_like/scene/json.hpp"
#include "toolchain/bench/scene_cost.hpp"

namespace sortie::toolchain {

namespace {

firmware::Json to_json(const SceneCost& cost) {
  firmware::Json object{{"bytes", cost.bytes},
                        {"us_per_tick", cost.us_per_tick},
                        {"us_per_tick_least", cost.least_us},
                        {"us_per_tick_most", cost.most_us}};
  if (cost.instructions_per_tick > 0) object["instructions_per_tick"] = cost.instructions_per_tick;
  object["errors"] = cost.errors;
  if (!cost.driven.empty()) {
    object["driven"] = cost.driven;
    object["end_off_m"] = cost.end_off_m;
  }
  return object;
}

// The error that a scene is judged by: of the place, or where there is none of the attitude.
const char* judge_of(const SceneCost& whole) {
  return whole.errors.count("ate_rmse_m") != 0 ? "ate_rmse_m" : "inclination_rmse_deg";
}

std::string cost_figure(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string cost_error(const std::map<std::string, double>& errors, const char* name) {
  const auto found = errors.find(name);
  return found == errors.end() ? "-" : cost_figure("%.4f", found->second);
}

// The first column is as wide as the longest name.
std::string cost_row(std::size_t wide, const std::string& name, const std::string& bytes,
                     const std::string& time, const std::string& instructions, const std::string& error,
                     const std::string& driven, const std::string& end) {
  char text[256];
  std::snprintf(text, sizeof(text), "%12s %10s %12s %10s %10s %9s\n", bytes.c_str(), time.c_str(),
                instructions.c_str(), error.c_str(), driven.c_str(), end.c_str());
  return name + std::string(wide - std::min(wide, name.size()) + 1, ' ') + text;
}

}  // namespace

firmware::Json to_json(const SceneCosts& costs) {
  firmware::Json object{{"scene", costs.scene}, {"machine", costs.machine}, {"ticks", costs.ticks}};
  object["whole"] = to_json(costs.whole);
  if (costs.drive_us > 0) {
    object["drive_us_per_tick"] = costs.drive_us;
    object["recorded_drive_us_per_tick"] = costs.recorded_us;
  }
  if (costs.has_live) {
    object["recorder_us_per_tick"] = costs.recorder_us;
    object["telemetry_us_per_tick"] = costs.telemetry_us;
  }
  object["without"] = firmware::Json::array();
  for (const PartCost& line : costs.without) {
    firmware::Json entry{{"part", line.part}, {"what", line.what}};
    if (line.refused.empty()) {
      entry.update(to_json(line.cost));
      entry["saves_bytes"] =
          static_cast<std::int64_t>(costs.whole.bytes) - static_cast<std::int64_t>(line.cost.bytes);
      if (line.is_outlet && !costs.has_live) {
        for (const char* key : {"us_per_tick", "us_per_tick_least", "us_per_tick_most"}) entry.erase(key);
      } else {
        entry["saves_us_per_tick"] = costs.whole.us_per_tick - line.cost.us_per_tick;
      }
    } else {
      entry["refused"] = line.refused;
    }
    object["without"].push_back(entry);
  }
  return object;
}

std::string scene_cost_table(const SceneCosts& costs) {
  const char* const judge = judge_of(costs.whole);
  const bool counted = costs.whole.instructions_per_tick > 0;
  std::string text = costs.scene + ", " + std::to_string(costs.ticks) + " ticks, " + costs.machine + "\n";
  std::size_t wide = 9;  // (nothing)
  for (const PartCost& part : costs.without) wide = std::max(wide, part.part.size());
  text += cost_row(wide, "without", "bytes", "us/tick", "instr/tick", "error", "driven", "ends off");
  const auto line = [&](const std::string& name, const SceneCost& cost, bool is_whole, bool has_time) {
    text += cost_row(wide, name, std::to_string(cost.bytes),
                     has_time ? cost_figure("%.3f", cost.us_per_tick) : "-",
                     counted ? cost_figure("%.1f", cost.instructions_per_tick) : "-",
                     cost_error(cost.errors, judge), cost_error(cost.driven, judge),
                     cost.driven.empty() || is_whole ? "-" : cost_figure("%.3f m", cost.end_off_m));
  };
  line("(nothing)", costs.whole, true, true);
  for (const PartCost& part : costs.without) {
    if (part.refused.empty()) line(part.part, part.cost, false, !part.is_outlet || costs.has_live);
  }
  for (const PartCost& part : costs.without) {
    if (!part.refused.empty()) text += "stays: " + part.part + ": " + part.refused + "\n";
  }
  text += "error: " + std::string(judge) +
          " of the same inputs replayed; driven: of a simulated drive of its own\n";
  if (costs.has_live) {
    text += "us/tick holds what recorder and telemetry took in a live drive: " +
            cost_figure("%.3f", costs.recorder_us) + " and " + cost_figure("%.3f", costs.telemetry_us) + "\n";
  }
  if (costs.drive_us > 0) {
    text += "the simulated drive takes " + cost_figure("%.2f", costs.drive_us) +
            " us/tick with all of its plant, recorded " + cost_figure("%.2f", costs.recorded_us) + "\n";
  }
  return text;
}

}  // namespace sortie::toolchain
