# Writes OUT: every file of FILES as a raw string in a table sorted by name. Run with cmake -P.
set(rows "")
separate_arguments(FILES)
list(SORT FILES)
foreach(file IN LISTS FILES)
  get_filename_component(name ${file} NAME_WE)
  file(READ ${file} text)
  string(APPEND rows "      {\"${name}\", R\"scene(${text})scene\"},\n")
endforeach()
file(WRITE ${OUT} "// Written by toolchain/embed_scenes.cmake.
#include \"firmware_like/scene/profile.hpp\"

namespace sortie::firmware {
const std::vector<BuiltInScene>& built_in_scenes() {
  static const std::vector<BuiltInScene> scenes{
${rows}  };
  return scenes;
}
}  // namespace sortie::firmware
")
