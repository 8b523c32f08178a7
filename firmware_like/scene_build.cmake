# -DSORTIE_SCENE=name (or a .toml file): a program for that scene alone. What the scene does not name is no code: a header that the
# scene's profile makes says which parts there are (rt/built_parts.hpp), and the linker drops what nobody refers to. No
# simulated robot, no sweeps, no clients; those stay with the program that has all scenes.
set(all_scenes ${CMAKE_CURRENT_BINARY_DIR}/all_scenes.cpp)
add_custom_command(OUTPUT ${all_scenes}
  COMMAND ${CMAKE_COMMAND} -DOUT=${all_scenes} "-DFILES=${scene_files}" -P ${PROJECT_SOURCE_DIR}/toolchain/embed_scenes.cmake
  DEPENDS ${scene_files} ${PROJECT_SOURCE_DIR}/toolchain/embed_scenes.cmake VERBATIM)
# Reads the scene as the program does. Not linked with our libraries: they wait for the header that it writes.
add_executable(sortie_scene_header commands/scene_header.cpp scene_parts.cpp profile.cpp profile_base.cpp profile_rows.cpp
  profile_script.cpp text_format.cpp ${all_scenes})
target_include_directories(sortie_scene_header PRIVATE ${PROJECT_SOURCE_DIR})
target_include_directories(sortie_scene_header SYSTEM PRIVATE ${SORTIE_TOML_INCLUDE})

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

list(APPEND not_in_library "/firmware_like/bench/" "/commands/(all_commands|bench|spy|drive|fly|plant|import|report|diff)[^/]*\\.cpp$")
set(benches "")
