// SPDX-License-Identifier: BSD-3-Clause
// Scenes that change another scene: found, read and laid over each other before anything is read from them.
#include <algorithm>
#include <fstream>
#include <sstream>

#include "firmware_like/scene/profile_text.hpp"
#include "firmware_like/scene/profile_tree.hpp"
#include "rt/built_parts.hpp"

namespace sortie::firmware {

namespace {

constexpr std::size_t kMostBases = 8;

bool is_file(const std::string& scene) {
  return scene.size() > 5 && scene.compare(scene.size() - 5, 5, ".toml") == 0;
}

// A base is a scene by name, or a file beside the one that names it.
std::string beside(const std::string& scene, const std::string& base) {
  const std::size_t slash = scene.rfind('/');
  if (!is_file(base) || base[0] == '/' || !is_file(scene) || slash == std::string::npos) return base;
  return scene.substr(0, slash + 1) + base;
}

// Takes `scene.base` out of a table. Empty where there is none.
std::string take_base(TomlTree& tree, const std::string& source) {
  const TomlNode base = tree.root().get("scene").get("base");
  if (!base) return {};
  std::string name = base.text().value_or("");
  if (name.empty()) {
    throw ProfileError(source + ":" + std::to_string(base.line()) +
                       ": scene.base: must be a scene's name or a .toml file, in quotes");
  }
  tree.erase("scene", "base");
  return name;
}

struct SceneText {
  std::string toml;
  std::string source;  // what messages call it
};

SceneText read_scene(const std::string& scene) {
  if (is_file(scene)) {
    std::ifstream file(scene, std::ios::binary);
    std::ostringstream bytes;
    if (!file || !(bytes << file.rdbuf())) {
      throw ProfileError(scene + ": cannot be read; give a file that exists, or a name from `sortie scenes`");
    }
    return {bytes.str(), scene};
  }
  std::string names;
  for (const BuiltInScene& built_in : built_in_scenes()) {
    if (scene == built_in.name) return {built_in.toml, scene + ".toml"};
    names.append(names.empty() ? "" : ", ").append(built_in.name);
  }
  if (*rt::kOnlyScene != '\0') {
    throw ProfileError("unknown scene \"" + scene + "\": this program was built for " + names +
                       " alone; take the program with all scenes, or build with -DSORTIE_SCENE=" + scene);
  }
  throw ProfileError("unknown scene \"" + scene + "\"; known: " + names + "; or give a .toml file");
}

}  // namespace

TomlTree parse_profile(const std::string& toml, const std::string& source) {
  if (const std::size_t line = line_of_bare_non_ascii(toml); line != 0) {
    throw ProfileError(
        source + ":" + std::to_string(line) +
        ": not valid TOML: a character beyond ASCII; put it in quotes, or behind # in a comment");
  }
  try {
    return TomlTree::parse(toml, source);
  } catch (const TomlError& error) {
    throw ProfileError(source + ":" + std::to_string(error.line()) + ": not valid TOML: " + error.what());
  }
}

LaidScene read_with_bases(const std::string& scene) {
  LaidScene result;
  std::vector<TomlTree> layers;
  std::vector<std::string> chain;
  for (std::string next = scene; !next.empty();) {
    if (std::find(chain.begin(), chain.end(), next) != chain.end())
      throw ProfileError(scene + ": scene.base leads back to " + next + "; a scene cannot be its own base");
    if (chain.size() > kMostBases) {
      throw ProfileError(scene + ": more than " + std::to_string(kMostBases) +
                         " scenes stand on each other; does one of them name itself by another path?");
    }
    SceneText text;
    try {
      text = read_scene(next);
    } catch (const ProfileError& error) {
      if (chain.empty()) throw;
      throw ProfileError(chain.back() + ": scene.base: " + error.what());
    }
    layers.push_back(parse_profile(text.toml, text.source));
    const std::string below = take_base(layers.back(), text.source);
    chain.push_back(next);
    next = below.empty() ? below : beside(next, below);
    if (chain.size() > 1) continue;
    result.source = text.source;
    result.base = next;
  }
  result.root = std::move(layers.back());
  for (std::size_t i = layers.size() - 1; i-- > 0;) result.root.lay_over(std::move(layers[i]));
  return result;
}

}  // namespace sortie::firmware
