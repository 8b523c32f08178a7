// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "firmware_like/scene/scene_parts.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "toolchain/sweep/sweep_plan.hpp"

namespace sortie::toolchain {

namespace {

// Knobs that the map's error judges.
bool is_of_map(std::string_view key) {
  return key.substr(0, 4) == "map." || key == "groups.mapping.rate_hz" || key == "limits.voxels";
}

bool builds(const SceneBuilder& build, std::vector<std::string> overrides, const std::string& more) {
  overrides.push_back(more);
  try {
    static_cast<void>(build(overrides));
  } catch (const firmware::ProfileError&) {
    return false;
  }
  return true;
}

// "off, euclidean, smoothness" of a text, "true, false" of a flag.
std::vector<std::string> choices_of(const firmware::ProfileKey& key) {
  std::vector<std::string> choices;
  std::istringstream in(key.range);
  const bool is_text = !key.value.empty() && key.value.front() == '"';
  for (std::string word; std::getline(in, word, ',');) {
    word.erase(0, word.find_first_not_of(' '));
    choices.push_back(is_text ? "\"" + word + "\"" : word);
  }
  return choices;
}

// The values with which the scene can be built.
std::vector<std::string> values_that_build(const SceneBuilder& build,
                                           const std::vector<std::string>& overrides,
                                           const firmware::ProfileKey& key) {
  std::vector<std::string> good;
  for (const std::string& value : knob_values(key)) {
    // A part of a whole number may be none.
    const std::string whole = firmware::format_exact(std::round(std::strtod(value.c_str(), nullptr)));
    if (same_value(value, key.value) || builds(build, overrides, key.path + "=" + value)) {
      good.push_back(value);
    } else if (key.high > key.low && whole != key.value && builds(build, overrides, key.path + "=" + whole)) {
      good.push_back(whole);
    }
  }
  return good;
}

// What a sweep of a knob does without.
std::vector<std::string> left_out(bool is_map, const std::vector<const firmware::ScenePart*>& parts) {
  std::vector<const firmware::ScenePart*> gone;
  for (const firmware::ScenePart* part : parts) {
    const std::string_view name = part->name;
    if ((name == "map" && !is_map) || name == "ssl" || name == "path") gone.push_back(part);
  }
  return gone.empty() ? std::vector<std::string>{} : firmware::overrides_without(gone);
}

}  // namespace

std::vector<std::string> knob_values(const firmware::ProfileKey& key) {
  if (key.high <= key.low) return choices_of(key);
  std::vector<std::string> values;
  for (const double factor : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    const double value = factor * key.number;
    if (value < key.low || value > key.high) continue;
    const std::string text = factor == 1.0 ? key.value : firmware::format_exact(value);
    if (std::find(values.begin(), values.end(), text) == values.end()) values.push_back(text);
  }
  return values;
}

std::vector<SweepOptions> each_knob_alone(const SceneBuilder& build, const SweepOptions& all) {
  const std::unique_ptr<firmware::Runtime> own = build(all.replay.overrides);
  const firmware::Profile& profile = own->profile();
  const std::vector<const firmware::ScenePart*> parts = firmware::parts_of(profile);
  std::vector<SweepOptions> sweeps;
  for (const firmware::ProfileKey& key : profile.keys()) {
    if (!key.is_knob) continue;
    std::vector<std::string> values = values_that_build(build, all.replay.overrides, key);
    if (values.size() < 2) continue;
    const bool is_map = is_of_map(key.path);
    SweepOptions& one = sweeps.emplace_back(all);
    one.each_knob = false;
    one.knobs = {{key.path, std::move(values)}};
    for (std::string& without : left_out(is_map, parts)) one.replay.overrides.push_back(std::move(without));
    if (is_map && one.error.empty()) one.error = "map_disagreement";
  }
  if (sweeps.empty())
    throw firmware::ProfileError("--sweep knobs: scene " + profile.name() +
                                 " has none; give --sweep key=v1,v2,v3");
  return sweeps;
}

}  // namespace sortie::toolchain
