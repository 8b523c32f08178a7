// SPDX-License-Identifier: BSD-3-Clause
// What a scene can leave out, part by part: how a profile says so, what needs the part, and which code it is.
#pragma once

#include <string>
#include <vector>

#include "firmware_like/scene/profile.hpp"

namespace sortie::firmware {

/// One part of part_list.hpp. A part is there when its vehicle is the scene's, its parent is there, and its
/// key says so.
struct ScenePart {
  const char* name;
  const char* what;     ///< half a sentence
  const char* vehicle;  ///< empty: of both
  const char* parent;   ///< what it works on; empty: nothing
  const char* key;      ///< a flag, a text or a number; a number is there unless it is 0
  const char* there;    ///< of a text: the values that mean "there", between spaces; otherwise empty
  const char* usual;    ///< without the key: "yes", "no", or the name of the part that it goes with
  const char* without;  ///< overrides that leave it out, between spaces
  bool code;            ///< false: its code is not separate from its parent's
};

/// The part of that name, or null.
const ScenePart* find_scene_part(const std::string& name);

/// The parts that `profile` has, parents before children. Reads a copy: nothing is declared.
std::vector<const ScenePart*> parts_of(const Profile& profile);

/// "odometry+drive": the names of several.
std::string joined_names(const std::vector<const ScenePart*>& parts);

/// Overrides that leave `parts` out.
std::vector<std::string> overrides_without(const std::vector<const ScenePart*>& parts);

/// `part` and all of `present` that have a task of their own and stand on it, on what stands on it, and so
/// on: what goes when it goes. Parents before children.
std::vector<const ScenePart*> with_dependants(const ScenePart& part,
                                              const std::vector<const ScenePart*>& present);

/// Names of the vehicle and of the parts whose code a build of that profile alone must have, between spaces.
std::string code_of(const Profile& profile);

/// One line for a build of one scene: that it has no `what`, and which build has it.
std::string not_in_this_build(const std::string& what, const std::string& scene);

/// ProfileError, with the cure, when this build lacks the code of a part that `profile` has.
void refuse_unbuilt_parts(const Profile& profile);

}  // namespace sortie::firmware
