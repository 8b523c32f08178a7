// SPDX-License-Identifier: BSD-3-Clause
// [[script]] of a profile, and which of its numbers may change while a run goes on.
#include <algorithm>
#include <limits>

#include "firmware_like/profile_tree.hpp"

namespace sortie::firmware {

namespace {
constexpr double kLatest_s = 1e7;  // as long as the longest run
}

std::vector<ScriptLine> Profile::script() {
  std::vector<ScriptLine> lines;
  const auto node = tree_->root.at_path("script");
  const toml::array* rows = node.as_array();
  if (node && rows == nullptr)
    fail("script", "must be a list: [[script]] at_s = ..., set = \"...\", value = ...");
  for (std::size_t i = 0; rows != nullptr && i < rows->size(); ++i) {
    const std::string path = "script[" + std::to_string(i) + "]";
    const toml::table* row = rows->get(i)->as_table();
    if (row == nullptr) fail(path, "must be a table with at_s, set and value");
    for (const auto& [key, unused] : *row) {
      const std::string_view name = key.str();
      if (name != "at_s" && name != "set" && name != "value")
        fail(path + "." + std::string(name), "unknown key; a script's row has at_s, set and value");
    }
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const double at_s = (*row)["at_s"].value_or(kNone);
    const std::string name = (*row)["set"].value_or(std::string());
    if (!(at_s >= 0 && at_s <= kLatest_s)) fail(path, "needs at_s = 0 .. 1e7, seconds from the start");
    if (name.empty()) fail(path, "needs set = \"name of a run-time parameter\"");
    if (!(*row)["value"].is_number()) fail(path, "needs value = a number");
    lines.push_back({at_s, name, (*row)["value"].value_or(kNone), i});
  }
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.at_s < b.at_s; });
  declare("script", std::to_string(lines.size()) + " changes", "", "rows of at_s, set, value",
          "changes of run-time parameters that a run makes by itself; a replay takes them from the log",
          !node);
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
