// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/scene_parts.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>

namespace sortie::firmware {

namespace {

using rt::Part;

constexpr ScenePart kParts[] = {
    {"attitude", "which way is down, from the IMU", "ugv", "", "tasks.attitude.enabled", "", "yes",
     "tasks.attitude.enabled=false", Part::attitude},
    {"gyro_bias", "the gyro's bias is estimated", "ugv", "attitude", "attitude.bias_sigma_rad_s", "", "yes",
     "attitude.bias_sigma_rad_s=0", Part::count},
    {"odometry", "dead reckoning from tracks and attitude", "ugv", "attitude", "tasks.odometry.enabled", "",
     "yes", "tasks.odometry.enabled=false", Part::odometry},
    {"track_aid", "the tracks' acceleration is taken out of the specific force", "ugv", "odometry",
     "attitude.track_aid", "on", "yes", "attitude.track_aid=off", Part::count},
    {"steering", "slip is judged by what the gyro has shown", "ugv", "odometry", "odometry.steering",
     "learned", "no", "odometry.steering=fixed", Part::count},
    {"obstacles", "edges, falls and flippers under the robot are modelled", "ugv", "odometry",
     "odometry.obstacles", "on", "no", "odometry.obstacles=off", Part::obstacles},
    {"odometry_state", "the odometry tells its mode, slip and health", "ugv", "odometry",
     "tasks.odometry_state.enabled", "", "obstacles", "tasks.odometry_state.enabled=false", Part::count},
    {"drive", "the route is driven", "ugv", "odometry", "tasks.drive.enabled", "", "no",
     "tasks.drive.enabled=false", Part::drive},
    {"flippers", "flippers are set", "ugv", "drive", "tasks.flippers.enabled", "", "no",
     "tasks.flippers.enabled=false", Part::flippers},
    {"canopen", "the drives speak CANopen", "ugv", "drive", "drives.protocol", "canopen", "no",
     "drives.protocol=own", Part::canopen},
    {"odrive", "the drives are ODrives, on CANSimple", "ugv", "drive", "drives.protocol", "odrive", "no",
     "drives.protocol=own", Part::odrive},
    {"map", "a local map of voxels", "ugv", "", "tasks.map.enabled", "", "no", "tasks.map.enabled=false",
     Part::map},
    {"self_filter", "returns from the robot itself are taken out", "ugv", "map", "outline.flipper_length_m",
     "", "no", "outline.flipper_length_m=0 outline.body_m=[0,0,0,0,0,0] outline.tracks_m=[0,0,0,0,0,0]",
     Part::count},
    {"segments", "the map is divided into segments", "ugv", "map", "map.segments", "euclidean smoothness",
     "yes", "map.segments=off", Part::segments},
    {"normals", "segments are smooth surfaces, by normals", "ugv", "segments", "map.segments", "smoothness",
     "no", "map.segments=euclidean", Part::normals},
    {"segment_lists", "lists of segments are published", "ugv", "segments", "map.publish",
     "segments features", "yes", "map.publish=off", Part::segment_lists},
    {"ssl", "a solid-state lidar is asked for rays", "ugv", "", "tasks.ssl.enabled", "", "no",
     "tasks.ssl.enabled=false", Part::ssl},
    {"ray_scheduler", "rays are planned over a map of what is known", "ugv", "ssl", "ssl.policy", "scheduled",
     "yes", "ssl.policy=grid", Part::ray_scheduler},
    {"pilot", "the vehicle is flown", "uav", "", "tasks.pilot.enabled", "", "yes",
     "tasks.pilot.enabled=false", Part::pilot},
    {"path", "ways around what is in the way", "uav", "pilot", "tasks.path.enabled", "", "no",
     "tasks.path.enabled=false", Part::path},
    {"sensed_map", "what is in the way is seen by a lidar", "uav", "path", "flight_map.source", "lidar", "no",
     "flight_map.source=given", Part::sensed_map},
    {"parameters", "numbers may change while a run goes on", "", "", "tasks.parameters.enabled", "", "yes",
     "tasks.parameters.enabled=false", Part::count},
    {"telemetry", "a live run tells over LCM what it does", "", "", "live.telemetry", "", "yes",
     "live.telemetry=false", Part::telemetry},
    {"recorder", "a run can be recorded", "", "", "live.recorder", "", "yes", "live.recorder=false",
     Part::recorder},
};

constexpr bool is_among(std::string_view word, std::string_view words) {
  std::size_t at = words.find(word);
  for (; at != std::string_view::npos; at = words.find(word, at + 1)) {
    const bool begins = at == 0 || words[at - 1] == ' ';
    const std::size_t end = at + word.size();
    if (begins && (end == words.size() || words[end] == ' ')) return true;
  }
  return false;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

bool holds(const std::vector<const ScenePart*>& parts, std::string_view name) {
  return std::any_of(parts.begin(), parts.end(),
                     [name](const ScenePart* part) { return name == part->name; });
}

bool is_there(Profile& profile, const ScenePart& part, const std::vector<const ScenePart*>& before) {
  const std::string_view vehicle = part.vehicle;
  if (!vehicle.empty() && vehicle != profile.vehicle()) return false;
  if (*part.parent != '\0' && !holds(before, part.parent)) return false;
  const std::string_view usual = part.usual;
  const bool fallback = usual == "yes" || (usual != "no" && holds(before, usual));
  if (!profile.has(part.key)) return fallback;
  if (*part.there != '\0') return is_among(profile.text(part.key, "", ""), part.there);
  if (std::string_view(part.without).find("=false") != std::string_view::npos)
    return profile.flag(part.key, fallback, "");
  return profile.number(part.key, {0, -1e12, 1e12, "", ""}) != 0.0;
}

}  // namespace

std::span<const ScenePart> scene_parts() { return kParts; }

const ScenePart* find_scene_part(const std::string& name) {
  const auto found = std::find_if(std::begin(kParts), std::end(kParts),
                                  [&](const ScenePart& part) { return name == part.name; });
  return found == std::end(kParts) ? nullptr : found;
}

std::vector<const ScenePart*> parts_of(const Profile& profile) {
  Profile copy(profile.canonical(), profile.name());
  std::vector<const ScenePart*> parts;
  for (const ScenePart& part : kParts) {
    if (is_there(copy, part, parts)) parts.push_back(&part);
  }
  return parts;
}

std::string joined_names(const std::vector<const ScenePart*>& parts) {
  std::string names;
  for (const ScenePart* part : parts) names += (names.empty() ? "" : "+") + std::string(part->name);
  return names;
}

std::vector<std::string> overrides_without(const ScenePart& part) {
  return overrides_without(std::vector<const ScenePart*>{&part});
}

std::vector<std::string> overrides_without(const std::vector<const ScenePart*>& parts) {
  std::vector<std::string> overrides;
  for (const ScenePart* part : parts) {
    const std::vector<std::string> words = words_of(part->without);
    overrides.insert(overrides.end(), words.begin(), words.end());
  }
  overrides.emplace_back("scene.unknown_keys=ignore");  // what the part alone knows stays in the profile
  return overrides;
}

namespace {

// What only refines its parent goes with it; what has a task of its own needs it.
bool has_task(const ScenePart& part) {
  return part.code != Part::count && std::string_view(part.key).rfind("tasks.", 0) == 0;
}

}  // namespace

std::vector<const ScenePart*> with_dependants(const ScenePart& part,
                                              const std::vector<const ScenePart*>& present) {
  std::vector<const ScenePart*> all{&part};
  for (const ScenePart* other : present) {  // parents come before children
    const bool stands_on = std::any_of(all.begin(), all.end(), [other](const ScenePart* gone) {
      return std::string_view(other->parent) == gone->name;
    });
    if (stands_on && has_task(*other)) all.push_back(other);
  }
  return all;
}

rt::PartMask code_of(const Profile& profile) {
  rt::PartMask mask = rt::mask_of(profile.vehicle() == "uav" ? Part::uav : Part::ugv);
  for (const ScenePart* part : parts_of(profile)) {
    if (part->code != Part::count) mask |= rt::mask_of(part->code);
  }
  return mask;
}

std::string not_in_this_build(const std::string& what, const std::string& scene) {
  return "this program was built for the scene " + std::string(rt::kOnlyScene) + " alone and has no " + what +
         "; take the program with all scenes, or build with -DSORTIE_SCENE=" + scene;
}

void refuse_unbuilt_parts(const Profile& profile) {
  if (*rt::kOnlyScene == '\0') return;
  for (const ScenePart* part : parts_of(profile)) {
    if (part->code == Part::count || rt::is_built(part->code)) continue;
    profile.fail(part->key,
                 not_in_this_build(std::string(part->name) + " (" + part->what + ")", profile.name()));
  }
}

}  // namespace sortie::firmware
