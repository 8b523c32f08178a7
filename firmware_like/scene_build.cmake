# -DSORTIE_SCENE=name (or a .toml file): a program for that scene alone. What the scene does not name is no code: a header that the
# scene's profile makes says which parts there are (rt/built_parts.hpp), and the linker drops what nobody refers to. Nothing of
# toolchain/ or hil/ is built: sweeps, clients and simulated robots stay with the program that has all scenes.
include(scene_header.cmake)

set(scene_code ${CMAKE_CURRENT_BINARY_DIR}/only_scene.cpp)
set(scene_folder ${PROJECT_BINARY_DIR}/scene_build)
file(MAKE_DIRECTORY ${scene_folder})
# Another scene in the same folder is another command line, so both are written anew.
add_custom_command(OUTPUT ${scene_folder}/sortie_scene_build.hpp ${scene_code}
  COMMAND sortie_scene_header ${SORTIE_SCENE} ${scene_folder}/sortie_scene_build.hpp ${scene_code}
  DEPENDS sortie_scene_header ${scene_files} VERBATIM)
add_custom_target(sortie_scene_parts DEPENDS ${scene_folder}/sortie_scene_build.hpp)
add_dependencies(sortie_strict sortie_scene_parts)
target_compile_definitions(sortie_strict INTERFACE SORTIE_ONE_SCENE)
target_include_directories(sortie_strict INTERFACE $<BUILD_INTERFACE:${scene_folder}>)
target_compile_options(sortie_strict INTERFACE -ffunction-sections -fdata-sections)
