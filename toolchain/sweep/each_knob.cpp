// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/sweep/each_knob.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "firmware_like/scene/scene_parts.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

constexpr AlgorithmKnob kKnobs[] = {
    {"attitude", "groups.control.rate_hz"},
    {"attitude", "imu.samples"},
    {"attitude", "attitude.acc_time_constant_s"},
    {"attitude", "attitude.bias_sigma_rad_s"},
    {"attitude", "attitude.bias_forgetting_s"},
    {"attitude", "attitude.block_ms"},
    {"attitude", "attitude.precision"},
    {"attitude", "attitude.track_aid"},
    {"odometry", "odometry.steering"},
    {"odometry", "odometry.obstacles"},
    {"odometry", "odometry.max_extrapolation_ms"},
    {"map", "groups.mapping.rate_hz"},
    {"map", "map.voxel_m"},
    {"map", "map.max_range_m"},
    {"map", "map.radius_m"},
    {"map", "map.min_points"},
    {"map", "map.mean_window"},
    {"map", "map.evict_blocks"},
    {"map", "map.forget_s"},
    {"map", "limits.voxels"},
    {"state", "groups.control.rate_hz"},
    {"state", "state.fix_sigma_m"},
    {"state", "state.fix_yaw_sigma_rad"},
    {"state", "state.gyr_noise_rad_s_rt_hz"},
    {"state", "state.acc_noise_m_s2_rt_hz"},
    {"state", "state.disturbance_hz"},
};

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

std::span<const AlgorithmKnob> algorithm_knobs() { return kKnobs; }

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
  const auto has_part = [&](std::string_view name) {
    if (name == "state") return profile.vehicle() == "uav";
    return std::any_of(parts.begin(), parts.end(),
                       [name](const firmware::ScenePart* part) { return name == part->name; });
  };
  std::vector<SweepOptions> sweeps;
  for (const AlgorithmKnob& knob : kKnobs) {
    const auto& keys = profile.keys();
    const auto declared = std::find_if(
        keys.begin(), keys.end(), [&knob](const firmware::ProfileKey& key) { return key.path == knob.key; });
    if (!has_part(knob.part) || declared == keys.end()) continue;
    std::vector<std::string> values = values_that_build(build, all.replay.overrides, *declared);
    if (values.size() < 2) continue;
    const bool is_map = std::string_view(knob.part) == "map";
    SweepOptions& one = sweeps.emplace_back(all);
    one.each_knob = false;
    one.knobs = {{knob.key, std::move(values)}};
    for (std::string& without : left_out(is_map, parts)) one.replay.overrides.push_back(std::move(without));
    if (is_map && one.error.empty()) one.error = "map_disagreement";
  }
  if (sweeps.empty())
    throw firmware::ProfileError("--sweep knobs: scene " + profile.name() +
                                 " has none; give --sweep key=v1,v2,v3");
  return sweeps;
}

}  // namespace sortie::toolchain
