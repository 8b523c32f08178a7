// SPDX-License-Identifier: BSD-3-Clause
// Lists in a profile: numbers, rows of a table, and [[script]] with the numbers that may change while a run
// goes on.
#include <algorithm>
#include <limits>
#include <sstream>

#include "firmware_like/scene/profile_tree.hpp"

namespace sortie::firmware {

namespace {

constexpr double kLatest_s = 1e7;  // of a script's row: as long as the longest run

std::string range_of(const NumberSpec& spec) {
  std::ostringstream out;
  out << spec.low << " .. " << spec.high << (*spec.unit.name != '\0' ? " " : "") << spec.unit.name;
  return out.str();
}

std::string names_of(const std::vector<ColumnSpec>& columns) {
  std::string names;
  for (const ColumnSpec& column : columns) names += (names.empty() ? "" : ", ") + std::string(column.name);
  return names;
}

}  // namespace

std::vector<double> Profile::numbers(const std::string& path, const std::vector<double>& fallback,
                                     const NumberSpec& spec) {
  std::vector<double> result = fallback;
  const TomlNode node = tree_->at_path(path);
  const std::string count = std::to_string(fallback.size());
  if (node) {
    if (!node.is_list() || node.size() != fallback.size())
      fail(path, "must be a list of " + count + " numbers");
    for (std::size_t i = 0; i < fallback.size(); ++i) {
      const std::optional<double> entry = node.at(i).number();
      if (!entry) fail(path, "must be a list of " + count + " numbers");
      result[i] = *entry;
      if (!(result[i] >= spec.low && result[i] <= spec.high))
        fail(path, "number " + std::to_string(i + 1) + " is outside " + range_of(spec));
    }
  }
  std::ostringstream shown;
  for (const double value : result) shown << (shown.tellp() == 0 ? "[" : ", ") << value;
  NumberSpec without_unit = spec;
  without_unit.unit = "";
  declare(path, shown.str() + "]", {.unit = spec.unit, .meaning = spec.meaning}, range_of(without_unit),
          !node);
  return result;
}

std::vector<ProfileRow> Profile::rows(const std::string& path, const std::vector<ColumnSpec>& columns,
                                      std::size_t most, const char* meaning) {
  std::vector<ProfileRow> result;
  const TomlNode list = tree_->at_path(path);
  if (list && !list.is_list()) fail(path, "must be a list: [[" + path + "]], with " + names_of(columns));
  if (list.size() > most)
    fail(path, std::to_string(list.size()) + " rows; at most " + std::to_string(most) + " fit");
  for (std::size_t i = 0; i < list.size(); ++i) {
    ProfileRow& row = result.emplace_back();
    row.path = path + "[" + std::to_string(i) + "]";
    const TomlNode table = list.at(i);
    if (!table.is_table()) fail(row.path, "must be a table with " + names_of(columns));
    for (const auto& [key, unused] : table.entries()) {
      bool known = false;
      for (const ColumnSpec& column : columns) known = known || key == column.name;
      if (!known) fail(row.path + "." + key, "unknown key; a row has " + names_of(columns));
    }
    for (const ColumnSpec& column : columns) {
      const std::string place = row.path + "." + column.name;
      const TomlNode entry = table.get(column.name);
      if (!entry && column.needed) fail(row.path, "needs " + std::string(column.name));
      if (column.kind == ColumnSpec::Kind::text) {
        if (entry && !entry.is_string()) fail(place, "must be a text in quotes");
        if (entry) row.texts[column.name] = *entry.text();
      } else if (column.kind == ColumnSpec::Kind::flag) {
        if (entry && !entry.is_boolean()) fail(place, "must be true or false");
        row.numbers[column.name] = entry.flag().value_or(false) ? 1.0 : 0.0;
      } else {
        if (entry && !entry.number()) fail(place, "must be a number");
        const double value = entry.number().value_or(column.number.fallback);
        if (!(value >= column.number.low && value <= column.number.high))
          fail(place, "must lie in " + range_of(column.number));
        row.numbers[column.name] = value;
      }
    }
  }
  declare(path, std::to_string(result.size()) + " rows", {.meaning = meaning},
          "at most " + std::to_string(most) + " rows of " + names_of(columns), !list);
  return result;
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
  const char* meaning =
      "changes of run-time parameters that a run makes by itself; a replay takes them from the log";
  declare("script", std::to_string(lines.size()) + " changes", {.meaning = meaning},
          "rows of at_s, set, value", !rows);
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
