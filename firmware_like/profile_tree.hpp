// SPDX-License-Identifier: BSD-3-Clause
// The parsed file behind a Profile, for the profile's own source files only.
#pragma once

#include <toml++/toml.h>

#include <string>

#include "firmware_like/profile.hpp"

namespace sortie::firmware {

/// Root table of a profile, overrides applied.
struct Profile::Tree {
  toml::table root;
  std::string base;  ///< of the scene that was named
};

/// Parses a file's text; ProfileError where it is not valid TOML.
toml::table parse_profile(const std::string& toml, const std::string& source);

/// The text of a scene by name or of a .toml file, and what names it in messages. ProfileError lists the
/// known names.
struct SceneText {
  std::string toml;
  std::string source;
};
SceneText read_scene(const std::string& scene);

/// Reads a scene and lays it over its base, over that one's base, and so on; `base` becomes the name of the
/// first. ProfileError names the file for a base that cannot be had, or a chain that leads back to itself.
toml::table read_with_bases(const std::string& scene, std::string& base);

}  // namespace sortie::firmware
