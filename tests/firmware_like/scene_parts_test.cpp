// SPDX-License-Identifier: BSD-3-Clause
// What scenes say that they leave out, beside what their runtimes are made of.
#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "firmware_like/robots/registry.hpp"
#include "firmware_like/runtime/runtime.hpp"
#include "firmware_like/scene/scene_parts.hpp"

using namespace sortie;
using namespace sortie::firmware;

namespace {

std::set<std::string> names_of(const std::vector<const ScenePart*>& parts) {
  std::set<std::string> names;
  for (const ScenePart* part : parts) names.insert(part->name);
  return names;
}

std::set<std::string> tasks_of(const Runtime& runtime) {
  std::set<std::string> names;
  for (std::uint32_t i = 0; i < runtime.executive().task_count(); ++i)
    names.insert(runtime.executive().task(i).name());
  return names;
}

// A part that has a task of its own is there exactly where the vehicle has built that task; of another part,
// its key has been read.
std::string first_disagreement(const std::set<std::string>& parts, const Runtime& runtime) {
  const std::set<std::string> tasks = tasks_of(runtime);
  for (const char* name : {"attitude", "odometry", "odometry_state", "drive", "flippers", "map", "locate",
                           "relocate", "ssl", "pilot", "path"}) {
    if (parts.count(name) != tasks.count(name)) return name;
  }
  const bool occupancy = tasks.count("occupancy") != 0;
  if ((parts.count("ray_scheduler") + parts.count("sensed_map") != 0) != occupancy) return "occupancy";
  for (const char* name : {"gyro_bias", "track_aid", "steering", "obstacles", "self_filter", "segments"}) {
    const ScenePart* part = find_scene_part(name);
    const auto& keys = runtime.profile().keys();
    const auto key =
        std::find_if(keys.begin(), keys.end(), [part](const auto& k) { return k.path == part->key; });
    const bool read = key != keys.end();
    const std::string value = read ? key->value : "";
    const bool on = read && value != "0" && value != "\"off\"" && value != "\"fixed\"";
    // The aid is a key of the attitude, and needs an odometry.
    const bool has_parent = parts.count(part->parent) != 0;
    if ((parts.count(name) != 0) != (on && has_parent)) return name;
  }
  return "";
}

}  // namespace

TEST_CASE("the parts that a scene names are the ones that its vehicle builds") {
  for (const BuiltInScene& scene : built_in_scenes()) {
    const Runtime runtime(load_scene(scene.name), own_vehicles(), RuntimeStart{});
    INFO(scene.name);
    CHECK(first_disagreement(names_of(parts_of(runtime.profile())), runtime) == "");
  }
  // The comparison can fail.
  const Runtime runtime(load_scene("ugv_stairs"), own_vehicles(), RuntimeStart{});
  for (const ScenePart* left_out : parts_of(runtime.profile())) {
    auto fewer = names_of(parts_of(runtime.profile()));
    fewer.erase(left_out->name);
    const std::set<std::string> unseen = {"segment_lists", "parameters", "canopen",
                                          "odrive",        "telemetry",  "recorder"};
    CHECK((first_disagreement(fewer, runtime) == "") == (unseen.count(left_out->name) != 0));
  }
}

TEST_CASE("each part of each scene can be left out") {
  for (const BuiltInScene& scene : built_in_scenes()) {
    const auto parts = parts_of(load_scene(scene.name));
    for (const ScenePart* part : parts) {
      INFO(scene.name << " without " << part->name);
      const auto after = names_of(parts_of(load_scene(scene.name, overrides_without({part}))));
      CHECK(after.count(part->name) == 0);
    }
  }
  const auto parts = parts_of(load_scene("ugv_stairs"));
  CHECK(joined_names(with_dependants(*find_scene_part("attitude"), parts)) ==
        "attitude+odometry+drive+flippers");
  CHECK(joined_names(with_dependants(*find_scene_part("map"), parts)) == "map");
  const auto after = names_of(parts_of(
      load_scene("ugv_stairs", overrides_without(with_dependants(*find_scene_part("odometry"), parts)))));
  for (const char* gone : {"odometry", "drive", "flippers", "obstacles"}) CHECK(after.count(gone) == 0);
  CHECK(after.count("attitude") == 1);
}

TEST_CASE("leaving a part out gives its memory back, and keeps what stays the same") {
  const Runtime whole(load_scene("ugv_hall"), own_vehicles(), RuntimeStart{});
  const Runtime without(load_scene("ugv_hall", overrides_without({find_scene_part("map")})), own_vehicles(),
                        RuntimeStart{});
  CHECK(tasks_of(whole).count("map") == 1);
  CHECK(tasks_of(without).count("map") == 0);
  CHECK(tasks_of(without).count("drive") == 1);
  CHECK(without.memory_bytes() * 10 < whole.memory_bytes());
}

TEST_CASE("eleven scenes are for real uses, and each says what it leaves out") {
  std::set<std::string> uses;
  for (const BuiltInScene& scene : built_in_scenes()) {
    const Profile profile = load_scene(scene.name);
    INFO(scene.name);
    if (profile.use().empty()) continue;
    CHECK(uses.insert(profile.use()).second);
    CHECK(profile.leaves_out().size() > 20);
    CHECK(profile.leaves_out().find('\n') == std::string::npos);
  }
  const std::set<std::string> expected = {"bench minimal", "building walk", "flat indoor", "lidar plane",
                                          "lidar walk",    "outdoor skid",  "rubble",      "SSL survey",
                                          "stairs",        "UAV and map",   "UAV corridor"};
  CHECK(uses == expected);
}

TEST_CASE("unknown keys are ignored only where a what-if asks for it") {
  const std::vector<std::string> misspelt = {"map.voxl_m=0.1"};
  CHECK_THROWS_AS(Runtime(load_scene("ugv_hall", misspelt), own_vehicles(), RuntimeStart{}), ProfileError);
  auto ignored = misspelt;
  ignored.emplace_back("scene.unknown_keys=ignore");
  CHECK_NOTHROW(Runtime(load_scene("ugv_hall", ignored), own_vehicles(), RuntimeStart{}));
}
