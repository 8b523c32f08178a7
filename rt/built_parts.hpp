// SPDX-License-Identifier: BSD-3-Clause
// What this build has. A build of one scene (-DSORTIE_SCENE=name) leaves out the code of the parts that the
// scene does not name; every other build has all of them.
#pragma once

#include <cstddef>
#include <string_view>

#ifdef SORTIE_ONE_SCENE
#include "sortie_scene_build.hpp"  // written by the build from the scene's profile
#endif

namespace sortie::rt {

#ifdef SORTIE_ONE_SCENE
/// Names of the parts, between spaces: kSceneParts has those of the scene.
inline constexpr std::string_view kBuiltParts = kSceneParts;
/// The scene that this program was built for; empty: for all.
inline constexpr const char* kOnlyScene = kSceneName;
#else
inline constexpr std::string_view kBuiltParts{};
inline constexpr const char* kOnlyScene = "";
#endif

/// True when `word` is one of `words`, which stand between spaces.
constexpr bool is_among(std::string_view word, std::string_view words) {
  std::size_t at = words.find(word);
  for (; at != std::string_view::npos; at = words.find(word, at + 1)) {
    const bool begins = at == 0 || words[at - 1] == ' ';
    const std::size_t end = at + word.size();
    if (begins && (end == words.size() || words[end] == ' ')) return true;
  }
  return false;
}

/// True where the code of the part of that name is in this build. Names as in
/// firmware_like/scene/part_list.hpp; a test holds those that stand in the code against that list.
constexpr bool is_built(std::string_view part) { return *kOnlyScene == '\0' || is_among(part, kBuiltParts); }

/// A name as an argument of a template.
template <std::size_t N>
struct PartName {
  char text[N]{};
  consteval PartName(const char (&name)[N]) {
    for (std::size_t i = 0; i < N; ++i) text[i] = name[i];
  }
};

/// The same as a constant: what it guards is no code otherwise, so that the linker never hears of it.
template <PartName part>
inline constexpr bool kBuilt = is_built(part.text);

}  // namespace sortie::rt
