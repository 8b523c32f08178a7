// SPDX-License-Identifier: BSD-3-Clause
// [[script]] of a profile, and which of its numbers may change while a run goes on.
#include <algorithm>
#include <limits>

#include "firmware_like/scene/profile_tree.hpp"

namespace sortie::firmware {

namespace {
constexpr double kLatest_s = 1e7;  // as long as the longest run
}

std::vector<ScriptLine> Profile::script() {
  std::vector<ScriptLine> lines;
  const TomlNode rows = tree_->at_path("script");
  if (rows && !rows.is_list())
    fail("script", "must be a list: [[script]] at_s = ..., set = \"...\", value = ...");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string path = "script[" + std::to_string(i) + "]";
    const TomlNode row = rows.at(i);
    if (!row.is_table()) fail(path, "must be a table with at_s, set and value");
    for (const auto& [key, unused] : row.entries()) {
      if (key != "at_s" && key != "set" && key != "value")
        fail(path + "." + key, "unknown key; a script's row has at_s, set and value");
    }
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const double at_s = row.get("at_s").number().value_or(kNone);
    const std::string name = row.get("set").text().value_or("");
    if (!(at_s >= 0 && at_s <= kLatest_s)) fail(path, "needs at_s = 0 .. 1e7, seconds from the start");
    if (name.empty()) fail(path, "needs set = \"name of a run-time parameter\"");
    if (!row.get("value").is_number()) fail(path, "needs value = a number");
    if (!row.get("value").number()) fail(path + ".value", kTooManyDigits);
    lines.push_back({at_s, name, *row.get("value").number(), i});
  }
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.at_s < b.at_s; });
  declare("script", std::to_string(lines.size()) + " changes", "", "rows of at_s, set, value",
          "changes of run-time parameters that a run makes by itself; a replay takes them from the log",
          !rows);
  return lines;
}

const ProfileKey& Profile::changeable(const std::string& path) {
  for (ProfileKey& key : keys_) {
    if (key.path != path || key.low >= key.high) continue;
    key.is_changeable = true;
    return key;
  }
  fail(path, "only a number that the profile has read can change while a run goes on");
}

}  // namespace sortie::firmware
