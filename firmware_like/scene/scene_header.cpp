// SPDX-License-Identifier: BSD-3-Clause
// Of the build: scene_header SCENE HEADER SOURCE writes which parts the scene has (rt/built_parts.hpp
// includes HEADER), and the scene as the only one that is built in, laid over its bases.
#include <fstream>
#include <iostream>

#include "firmware_like/scene/scene_parts.hpp"

namespace {

void write(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << "// Written by the build of one scene.\n" << text;
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: scene_header SCENE HEADER SOURCE\n";
    return 2;
  }
  try {
    const sortie::firmware::Profile profile = sortie::firmware::load_scene(argv[1]);
    write(argv[2], "#pragma once\n\nnamespace sortie::rt {\n\ninline constexpr const char* kSceneParts = \"" +
                       sortie::firmware::code_of(profile) +
                       "\";\ninline constexpr const char* kSceneName = \"" + profile.name() +
                       "\";\n\n}  // namespace sortie::rt\n");
    write(argv[3],
          "#include \"firmware_like/scene/profile.hpp\"\n\nnamespace sortie::firmware {\n"
          "const std::vector<BuiltInScene>& built_in_scenes() {\n  static const std::vector<BuiltInScene> "
          "scenes{{\"" +
              profile.name() + "\", R\"scene(" + profile.canonical() +
              ")scene\"}};\n  return scenes;\n}\n}  // namespace sortie::firmware\n");
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 1;
  }
  return 0;
}
