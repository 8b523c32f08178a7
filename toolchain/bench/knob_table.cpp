// SPDX-License-Identifier: BSD-3-Clause
#include "toolchain/bench/knob_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "firmware_like/scene/scene_parts.hpp"
#include "firmware_like/scene/text_format.hpp"

namespace sortie::toolchain {

namespace {

constexpr Knob kKnobs[] = {
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

bool builds(const std::string& scene, std::vector<std::string> overrides, const std::string& more,
            const firmware::VehicleRegistry& vehicles) {
  overrides.push_back(more);
  try {
    static_cast<void>(
        firmware::Runtime(firmware::load_scene(scene, overrides), vehicles, firmware::RuntimeStart{}));
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

}  // namespace

std::span<const Knob> algorithm_knobs() { return kKnobs; }

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

std::vector<KnobTrial> knob_trials(const std::string& scene, const std::vector<std::string>& overrides,
                                   const firmware::VehicleRegistry& vehicles) {
  const firmware::Runtime own(firmware::load_scene(scene, overrides), vehicles, firmware::RuntimeStart{});
  const std::vector<const firmware::ScenePart*> parts = firmware::parts_of(own.profile());
  const auto has_part = [&](std::string_view name) {
    if (name == "state") return own.profile().vehicle() == "uav";
    return std::any_of(parts.begin(), parts.end(),
                       [name](const firmware::ScenePart* part) { return name == part->name; });
  };
  std::vector<KnobTrial> trials;
  for (const Knob& knob : kKnobs) {
    const auto& keys = own.profile().keys();
    const auto declared = std::find_if(
        keys.begin(), keys.end(), [&knob](const firmware::ProfileKey& key) { return key.path == knob.key; });
    if (!has_part(knob.part) || declared == keys.end()) continue;
    KnobTrial trial{knob, *declared, {}};
    const std::string set = std::string(knob.key) + "=";
    for (const std::string& value : knob_values(*declared)) {
      // A part of a whole number may be none.
      const std::string whole = firmware::format_exact(std::round(std::strtod(value.c_str(), nullptr)));
      if (same_value(value, declared->value) || builds(scene, overrides, set + value, vehicles)) {
        trial.tried.push_back(value);
      } else if (declared->high > declared->low && whole != declared->value &&
                 builds(scene, overrides, set + whole, vehicles)) {
        trial.tried.push_back(whole);
      }
    }
    if (trial.tried.size() > 1) trials.push_back(std::move(trial));
  }
  return trials;
}

std::vector<std::string> knob_overrides(const Knob& knob, const firmware::Profile& profile) {
  const std::string_view part = knob.part;
  const std::vector<const firmware::ScenePart*> parts = firmware::parts_of(profile);
  std::vector<const firmware::ScenePart*> gone;
  for (const firmware::ScenePart* other : parts) {
    const std::string_view name = other->name;
    if ((name == "map" && part != "map") || name == "ssl" || name == "path") gone.push_back(other);
  }
  return gone.empty() ? std::vector<std::string>{} : firmware::overrides_without(gone);
}

}  // namespace sortie::toolchain
