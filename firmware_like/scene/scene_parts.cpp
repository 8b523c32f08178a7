// SPDX-License-Identifier: BSD-3-Clause
#include "firmware_like/scene/scene_parts.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "firmware_like/scene/part_list.hpp"
#include "firmware_like/scene/text_format.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

namespace {

constexpr ScenePart kParts[] = {
#define SORTIE_PART(name, what, vehicle, parent, usual) \
  {#name, what, vehicle, parent, "tasks." #name ".enabled", "", usual, "tasks." #name ".enabled=false", true},
#define SORTIE_OPTION(name, what, vehicle, parent, usual, key, there, without, code) \
  {#name, what, vehicle, parent, key, there, usual, without, code},
    SORTIE_PARTS(SORTIE_PART, SORTIE_OPTION)
#undef SORTIE_PART
#undef SORTIE_OPTION
};

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
  if (*part.there != '\0') return rt::is_among(profile.text(part.key, "", ""), part.there);
  if (std::string_view(part.without).find("=false") != std::string_view::npos)
    return profile.flag(part.key, fallback, "");
  return profile.number(part.key, {0, -1e12, 1e12, "", ""}) != 0.0;
}

// What only refines its parent goes with it; what has a task of its own needs it.
bool has_task(const ScenePart& part) {
  return part.code && std::string_view(part.key).rfind("tasks.", 0) == 0;
}

}  // namespace

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

std::vector<std::string> overrides_without(const std::vector<const ScenePart*>& parts) {
  std::vector<std::string> overrides;
  for (const ScenePart* part : parts)
    std::ranges::copy(split_words(part->without), std::back_inserter(overrides));
  overrides.emplace_back("scene.unknown_keys=ignore");  // what the part alone knows stays in the profile
  return overrides;
}

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

std::string code_of(const Profile& profile) {
  std::string names = profile.vehicle();
  for (const ScenePart* part : parts_of(profile)) {
    if (part->code) names += std::string(" ") + part->name;
  }
  return names;
}

std::string not_in_this_build(const std::string& what, const std::string& scene) {
  return "this program was built for the scene " + std::string(rt::kOnlyScene) + " alone and has no " + what +
         "; take the program with all scenes, or build with -DSORTIE_SCENE=" + scene;
}

void refuse_unbuilt_parts(const Profile& profile) {
  if (*rt::kOnlyScene == '\0') return;
  for (const ScenePart* part : parts_of(profile)) {
    if (!part->code || rt::is_built(part->name)) continue;
    profile.fail(part->key,
                 not_in_this_build(std::string(part->name) + " (" + part->what + ")", profile.name()));
  }
}

}  // namespace sortie::firmware
