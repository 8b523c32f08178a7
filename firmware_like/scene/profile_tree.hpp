// SPDX-License-Identifier: BSD-3-Clause
// The parsed file behind a Profile, for the profile's own source files only.
#pragma once

#include <string>

#include "firmware_like/scene/profile.hpp"
#include "firmware_like/scene/toml_file.hpp"

namespace sortie::firmware {

/// Parses a file's text; ProfileError where it is not valid TOML.
TomlTree parse_profile(const std::string& toml, const std::string& source);

/// A scene, laid over what it stands on.
struct LaidScene {
  TomlTree root;
  std::string base;    ///< of the scene that was named; empty if it has none
  std::string source;  ///< what messages call the scene's own file
};

/// Reads a scene by name or from a .toml file and lays it over its base, over that one's base, and so on.
/// ProfileError lists the known names, names the file for a base that cannot be had, or a chain that leads
/// back to itself.
LaidScene read_with_bases(const std::string& scene);

}  // namespace sortie::firmware
